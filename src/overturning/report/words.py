"""What the report says differently of each model. To add a model, add its words to `WORDS`."""

from dataclasses import dataclass, replace
from typing import Final

import xarray as xr

from overturning.model.body import Body
from overturning.model.falls import model_of
from overturning.model.model import Model
from overturning.model.planes import Planes, azimuth_period_deg
from overturning.model.symmetry import PLANE_PERIOD


@dataclass(frozen=True)
class Words:
    """Sentences, and parts of them, about one model.

    Attributes
    ----------
    model, limit : str
        What is computed, and what it leaves out.
    copies : str
        What the cells are that were not computed.
    blocks, which : str
        Those whose falls tell a direction (`statistics.falls.informative_blocks`), and which these are.
    why_these : str
        Why these blocks are chosen, and not those of the other model.
    weighed : str
        With what weight each case counts in directions where there is an ensemble.
    rose, map : str
        Captions of the rose, and of a record's map; in the latter stands where probabilities are shown.
    means : str
        How a record's mean directions and axes are counted, and what they are.
    apart : str
        How many members of the ensemble fall their own way; a share stands in it.
    stone_falls, stone_stays : str
        When a stone of the population falls, and when one that stands is counted as shifted, by so many cm, and as
        rotated, by so many degrees.
    """

    model: str
    limit: str
    copies: str
    blocks: str
    which: str
    why_these: str
    weighed: str
    rose: str
    map: str
    means: str
    apart: str
    stone_falls: str
    stone_stays: str


_MEANS: Final = (
    "A direction has a head (towards 60°), an axis has none (60° and 240° are the same); a resultant of 1 means all "
    "falls alike, of 0 falls to every side alike, so no mean is given below 0.05"
)

_ROSE: Final = (
    "Each earthquake counts once, its records alike; the area of a sector is its mean share, with a 95 % interval by "
    "bootstrap over earthquakes for each sector by itself. In half a disk opposite directions are one axis; at its rim "
    "the mean axis with its 95 % interval, where there is one."
)

WORDS: Final[dict[type[Model], Words]] = {
    Planes: Words(
        model="A rigid block on a base that moves with the record, computed by the distinct element method in the "
        "vertical plane of each azimuth.",
        limit="The model is plane: a real stone may stand oblique to the motion, twist, or be a stack of several.",
        copies="their mirror images",
        blocks="blocks that only just fall",
        which="A block only just falls under a record if it overturns in some of its planes, and in at most half of "
        "them. More slender ones fall every way and tell nothing about direction; of a record without such blocks all "
        "count.",
        why_these="A slender block falls in every plane, as each plane has a component of the motion, so its falls go "
        "every way whatever the motion; in space such a block still falls where the motion sends it, so reports of "
        "studies in space count all blocks.",
        weighed="the probability of its fall over its neighbourhood; the rose counts the falls of the cases themselves",
        rose=f"Azimuths towards which the blocks fall that only just fall, each plane once. {_ROSE}",
        map="Angle: the azimuth towards which the block falls, north up, clockwise. Radius: slenderness B/H. {chance}"
        "Read one half: the other repeats it reversed, dark where this one is white.",
        means=f"Over the blocks that only just fall under a record, each plane once. {_MEANS}. Easiest axis: along it "
        "the lowest block at the highest friction overturns up to the largest B/H, of several such planes their mean "
        "axis; easier by: that B/H over the one of the hardest azimuth.",
        apart="in {} most of these fall, but not all to the same side.",
        stone_falls="falls if it falls in one of the planes of its faces",
        stone_stays="Whether stones turned about their vertical axis no plane can tell, nor how far they slid: both "
        "components at once move more of them. A study in space has the rates of shifted and rotated stones.",
    ),
    Body: Words(
        model="A rigid convex body on a base that moves with all components of the record, computed by the distinct "
        "element method in space: contact at vertices, friction in both directions, free to turn. Its orientation is "
        "the azimuth that its first side faces.",
        limit="The body is one rigid stone on a level, flat base; a real one may be a stack, or stand in a socket.",
        copies="the same",
        blocks="all blocks",
        which="",
        why_these="All blocks count here, unlike in the report of a study in planes: a block that falls whichever way "
        "it faces is moved by both components at once, so that its falls show a direction, while in planes such a "
        "block falls in every plane and its falls go every way.",
        weighed="the probability and the resultant of its falls over its neighbourhood, the rose with the resultant, "
        "so that a fall which goes elsewhere under nearly the same motion adds little",
        rose=f"Azimuths towards which blocks fall, each with its resultant over the ensemble where it was run. {_ROSE}",
        map="Across: the azimuth that the first side of the block faces; up: slenderness B/H; colour and arrow: the "
        "azimuth of the fall, north up. Beside it the rose of the falls in these maps.",
        means=f"Over all cases of a record. {_MEANS}.",
        apart="where all runs fall, their directions spread by more than 15° about their mean in {}.",
        stone_falls="does what the prism does",
        stone_stays="Shifted: it stands, its base moved by {:g} cm or more. Rotated: it stands, turned by {:g}° or "
        "more about its vertical axis; a stone can be both.",
    ),
}

_NO_MIRROR_IMAGE: Final = replace(
    WORDS[Planes],
    map="Angle: the azimuth that the scene faces, north up, clockwise, and the block falls towards or away from it. "
    "Radius: slenderness B/H. {chance}Opposite azimuths are two cases: the scene is not its own mirror image.",
)

_OF_SEVERAL: Final = {
    "model": "Rigid stones that stand on one another, or side by side, on a base that moves with the record, computed "
    "by the distinct element method in the vertical plane of each azimuth.",
    "limit": "The model is plane: real stones may stand oblique to the motion, or twist.",
}


def words_of(cube: xr.Dataset, stones: int = 1) -> Words:
    """The words for a cube: those of its model, others of several stones, and of what is not its own mirror image."""
    model = model_of(cube)
    alike = not model.one_component or azimuth_period_deg(cube) == PLANE_PERIOD
    words = WORDS[type(model)] if alike else _NO_MIRROR_IMAGE
    return words if stones == 1 else replace(words, **_OF_SEVERAL)
