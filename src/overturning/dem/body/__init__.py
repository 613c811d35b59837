"""One convex body in space: a base that moves with all three components, contact at vertices or at a rim."""
