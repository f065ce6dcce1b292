"""The table of diagnostics (`transport checks`).

What each finding about a run detects, and what it cannot detect.
"""

from __future__ import annotations

from typing import NamedTuple

from transport.statistics.batches import MIN_SCORES_FOR_ERROR as FEW


class Diagnostic(NamedTuple):
    """An entry of the table: the name that its findings carry, what it detects, and what it cannot detect."""

    name: str
    detects: str
    cannot_detect: str


DIAGNOSTICS = (
    Diagnostic(
        "path class",
        f"Light that an estimator finds only by chance and that has fewer than {FEW} scores: via mirrors,"
        " glass, gloss or lenses, from beams, from very near, or from a lamp that backward histories rarely"
        " reach. Its bound is Poisson's 95 % limit times the largest score, or the result of a probe,"
        " whichever is less; a class that geometry proves to be empty is left out.",
        "Which surface the light comes from, if there are several; and a class with many, but unequal"
        " scores.",
    ),
    Diagnostic(
        "all light",
        f"A detector that light reaches only by chance, and that has fewer than {FEW} scores, or a sum below"
        f" {FEW} times the most that one history can score.",
        "Where the light would come from; light from very few histories with thousands of scores each,"
        " beside light from many histories, as between two mirrors of reflectance 0.9999; and a gap in a"
        " scattering medium, for which scores of all weights count alike.",
    ),
    Diagnostic(
        "strong rays",
        f"Rays from walls and lamps so near to a detector that each scores much, if fewer than {FEW} were"
        " counted.",
        "Which wall or lamp they would come from.",
    ),
    Diagnostic(
        "near emitter",
        "A point detector so near to a diffuse wall, an emitter or a scattering medium that hardly any"
        " history reaches the nearest spot, from where half of the light comes; and a small lamp nearby"
        " with hardly any births.",
        "Mirrors; a scene cannot have them beside point detectors.",
    ),
    Diagnostic(
        "unvisited surface",
        "A diffuse surface close to a detector with next-event estimation, if hardly any history reached it.",
        "A small bright spot on a large surface that histories reach elsewhere.",
    ),
    Diagnostic(
        "forward peak",
        "Scattering so sharply forward that one collision pointing at the detector would exceed the error.",
        "Peaks of tabulated phase functions narrower than their table.",
    ),
    Diagnostic(
        "roulette survivors",
        "Heavy survivors of Russian roulette, or uncollided histories through voxels, of which none may"
        " have come.",
        "Weight that was never followed, such as the directions that an aim leaves out.",
    ),
    Diagnostic(
        "few carriers",
        "An error that a few scores carry, though there may be many: from the variance of the variance, and"
        f" from a spread of the batches like that of fewer than {FEW} scores, as where one history scores"
        " hundreds of times.",
        "Scores that are still missing.",
    ),
    Diagnostic(
        "tail",
        "Larger scores that the law of the largest predicts, if none has come.",
        "A second kind of score, larger than the law predicts.",
    ),
    Diagnostic(
        "batches",
        "A trend from batch to batch, or one batch far above all others, which chance produces once in 1e6"
        " runs.",
        "Contributions that all batches miss.",
    ),
    Diagnostic(
        "unknown error",
        "A number without a score, or from batches that gave all the same; with sobol and stratified also"
        " batches that all have the same number of scores, so that their spread does not measure the error.",
        "Why there is no score.",
    ),
    Diagnostic(
        "bins",
        "Bins, cells and pixels whose error is unknown although the total is sound.",
        "Structure finer than a bin.",
    ),
    Diagnostic(
        "enclosed detector",
        "A detector that provably no light can reach: it is enclosed by opaque walls, behind every source,"
        " or facing away.",
        "Light that only chance missed; curved walls that separate two places without enclosing either.",
    ),
    Diagnostic(
        "optical depth",
        "A detector behind so many mean free paths that no run of this length resolves the transmitted"
        " light.",
        "Paths around a thick medium.",
    ),
    Diagnostic(
        "faint source",
        "A source with so small a share of the power that hardly any history is born on it.",
        f"A faint source whose light matters in few bins, if it has {FEW} histories or more.",
    ),
    Diagnostic(
        "grazing",
        "A fluence rate from crossings so close to grazing that it depends on the cut at |mu| = 0.001.",
        "Asymmetric light on which batches disagree; a few grazing crossings among steep ones that are"
        " still missing, each of which scores up to 1000 times as much.",
    ),
    Diagnostic(
        "aim",
        "A detector that sees an aimed source only in the directions of its aim.",
        "How much light the aim leaves out.",
    ),
    Diagnostic(
        "lost particles",
        "Particles lost at gaps and edges, or in media that contradict their surfaces.",
        "A gap that lets light escape from a scene without a medium.",
    ),
    Diagnostic("thin batches", "Batches with fewer histories than a sensor has bins.", ""),
)
