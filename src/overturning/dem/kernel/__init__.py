"""What all kernels share: lanes, clock, queue, ground, endings, compiled code; it knows lanes, not stones."""
