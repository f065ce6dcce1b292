"""The table of diagnostics: what each finding about a run detects, and what it cannot detect (`transport checks`)."""

from __future__ import annotations

from typing import NamedTuple


class Diagnostic(NamedTuple):
    """An entry of the table: its name, which its findings carry, what it detects, and what it cannot."""

    name: str
    detects: str
    cannot: str


DIAGNOSTICS = (
    Diagnostic(
        "path class",
        "Light that an estimator meets by chance alone and that has scored fewer than 25 times: by mirrors, glass, gloss and"
        " lenses, by beams, from very near, or a lamp that backward histories hardly meet. Its bound is Poisson's 95 % limit"
        " times the largest score, or what a probe finds, whichever is less; a class that geometry proves to be empty is"
        " left out.",
        "Which of the surfaces brings the light, if there are several; and a class whose scores are many but unlike.",
    ),
    Diagnostic(
        "all light",
        "A detector to which light comes by chance alone, and that has scored fewer than 25 times, or fewer than 25 times as much"
        " as one history can.",
        "Where the light would come from; light that very few histories bring, each by thousands of scores, beside what many"
        " bring, as between two mirrors of 0.9999; and a gap in a medium that scatters, for which scores of all weights count alike.",
    ),
    Diagnostic(
        "strong rays",
        "Rays from walls and lamps so near to a detector that each brings much, of which fewer than 25 have come.",
        "Which wall or lamp they would come from.",
    ),
    Diagnostic(
        "near emitter",
        "A point detector so near to a diffuse wall, an emitter or a scattering medium that hardly any history comes to the"
        " foot of it, from where half of its light comes; and a small lamp near it on which hardly any history is born.",
        "Mirrors; they are refused beside point detectors.",
    ),
    Diagnostic(
        "unvisited surface",
        "A diffuse surface close to a detector that sees events by rays, to which hardly any history has come.",
        "A small bright spot on a large surface that is visited elsewhere.",
    ),
    Diagnostic(
        "forward peak",
        "Scattering so sharply forward that one collision pointing at the detector would outweigh the error.",
        "Peaks of tabulated phase functions narrower than their table.",
    ),
    Diagnostic(
        "roulette survivors",
        "Heavy survivors of roulette, or histories through voxels without a collision, of which none may have come.",
        "Weight that was never followed, such as what an aim leaves out.",
    ),
    Diagnostic(
        "few carriers",
        "An error that a few scores carry, though there may be many: by the variance of the variance, and by a spread of batches"
        " as of fewer than 25 scores, as where one history brings hundreds.",
        "Scores that have not come yet.",
    ),
    Diagnostic(
        "tail",
        "Larger scores that the law of the largest foretells, but of which none has come.",
        "A second kind of score, larger than the law foretells.",
    ),
    Diagnostic(
        "batches",
        "A trend from batch to batch, or one batch far above all others, which chance makes once in 1e6 runs.",
        "What all batches miss alike.",
    ),
    Diagnostic(
        "unknown error",
        "A number without a score, or of batches that gave all the same; with sobol and stratified also of batches that all have"
        " as many scores, so that their spread tells nothing of one more.",
        "Why there is no score.",
    ),
    Diagnostic(
        "bins",
        "Bins, cells and pixels whose error is not known although the total is sound.",
        "Structure finer than a bin.",
    ),
    Diagnostic(
        "enclosed detector",
        "A detector that no light can reach, by proof: opaque walls, behind every source, or facing away.",
        "Light that chance alone has missed; curved walls that part two places without enclosing either.",
    ),
    Diagnostic(
        "optical depth",
        "A detector behind so many mean free paths that no run of this length sees through them.",
        "Ways round a thick medium.",
    ),
    Diagnostic(
        "faint source",
        "A source with so small a share of the power that hardly a history is born on it.",
        "A faint source whose light matters in few bins, if it has 25 histories or more.",
    ),
    Diagnostic(
        "grazing",
        "A fluence rate from crossings so flat that it rests on the cut at |mu| = 0.001.",
        "Lopsided light that batches do not agree about; a few flat crossings among steep ones that have not come yet, each of which"
        " scores up to 1000 times as much.",
    ),
    Diagnostic(
        "aim",
        "A detector that sees an aimed source only in the directions of its aim.",
        "How much light the aim leaves out.",
    ),
    Diagnostic(
        "lost particles",
        "Particles lost at gaps and edges, or in media that their surfaces contradict.",
        "A gap that lets light out of a scene without a medium.",
    ),
    Diagnostic("thin batches", "Batches with fewer histories than a sensor has bins.", ""),
)
