"""`transport verify`: laws, hard cases and the long proof; which estimates agree, and how small a bias would be caught."""

from __future__ import annotations

import json
import math
import signal
from contextlib import suppress
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from scipy.special import bdtr, bdtrc

from tests import agreement
from tests.own_experiments import EXPERIMENT
from tests.processes import pressing_ctrl_c
from transport.cli import verify
from transport.cli.laws import Law, split_law, z_score
from transport.statistics.estimates import Estimate
from transport.statistics.replicates import Batches
from transport.verification.hard import cases
from transport.verification.hard.cases import Case, CaseResult

LEVEL = 1e-3
TANK = """
import math
import transport as tp

law = "T = exp(-k d)"

def scene(k=1.0, d=2.0, albedo=0.0):
    fog = tp.Medium(absorption=k * (1 - albedo), scattering=k * albedo)
    tank = tp.Surface(tp.Slab(thickness=d), tp.Transparent(), inside=fog)
    lamp = tp.Source(tp.Point(position=(0, 0, -3)), tp.Beam((0, 0, 1), power=1.0))
    return tp.Scene(lamp, tank, tp.Detector(tp.Plane(center=(0, 0, 2)), "out"))

def measure(result):
    return {"T": result["out"].flux_in + result["out"].flux_out, "A": result.ledger["absorbed"]}

def exact(k=1.0, d=2.0, albedo=0.0):
    return {"T": RIGHT * math.exp(-k * d), "A": 1 - math.exp(-k * d)}

RIGHT = 1
"""


@pytest.fixture
def verified(call):
    """Verify the tank, with more code behind it: the answer, and the rows by their names."""

    def verified(more: str = ""):
        Path("tank.py").write_text(TANK + more, encoding="utf-8")
        arguments = ["verify", "tank.py", "--particles", "20000"]
        rows = json.loads(call(*arguments, "--json").stdout)
        return call(*arguments), {row["quantity"]: row for row in rows}

    return verified


# Laws


def test_verify_has_one_row_per_law_with_formula_source_and_smallest_bias(call):
    answer = call("verify", "disks.py")
    assert answer.exit_code == 0, answer.output
    assert "E = π L sin²θ on the axis of a diffuse disk (Foote 1915)" in answer.output
    assert sum(line.rstrip().endswith("holds") for line in answer.output.splitlines()) == 2
    rows = json.loads(call("verify", "disks.py", "--json").stdout)
    assert [row["quantity"] for row in rows] == ["distance=2: irradiance", "distance=4: irradiance"]
    keys = [
        "law",
        "source",
        "sim",
        "quantity",
        "value",
        "error",
        "unit",
        "exact",
        "z",
        "smallest_bias",
        "holds",
        "state",
    ]
    assert all(list(row) == keys and 0 < row["smallest_bias"] < 0.01 for row in rows)


def test_verify_fails_where_pi_is_forgotten(call):
    answer = call("verify", "wrong.py")
    assert answer.exit_code == 1 and "FAILS" in answer.output and "0 of 1 rows hold" in answer.output


def test_a_law_without_noise_holds_and_a_run_has_the_same_score(verified, call):
    """Absorption alone has no noise; the name stands behind the formula, whose brackets are no source."""
    answer, rows = verified()
    assert answer.exit_code == 0 and "2 of 2 rows hold" in answer.output
    assert answer.output.splitlines()[0].rstrip() == "T = exp(-k d) tank"
    assert [row["z"] for row in rows.values()] == [0, 0]
    assert all(row["error"] is None and row["source"] == "" for row in rows.values())
    record = json.loads(call("run", "tank.py", "--json", "--particles", "1000").stdout)
    assert [row["z"] for row in record["quantities"]] == [0, 0]
    shown = call("run", "tank.py", "--no-picture", "--particles", "1000").output
    assert sum(line.rstrip().endswith("+0.00") for line in shown.splitlines()) == 2


@pytest.mark.parametrize("factor", ["1 + 1e-11", "1 - 1e-11", "math.nextafter(1, 0) ** 10**5"])
def test_a_law_without_noise_fails_where_it_is_wrong(verified, factor):
    answer, rows = verified(f"\nRIGHT = {factor}\n")
    assert answer.exit_code == 1 and "1 of 2 rows hold" in answer.output
    assert rows["T"]["z"] is None and rows["T"]["smallest_bias"] is None and rows["A"]["z"] == 0


def test_a_wrong_value_is_shown_to_the_digit_that_is_wrong(verified):
    answer, _ = verified("\nRIGHT = 1.00001\n")
    (line,) = (line for line in answer.output.splitlines() if line.startswith("T  "))
    assert "0.1353353 (error unknown" in line and "0.135337 " in line


# The judge


def law_of(values, exact, size=1000, **how):
    run = Batches(np.full(len(values), size))
    return Law("", "", "", "", Estimate(np.array(values), run, "W", **how), exact)


def test_noise_below_rounding_is_none():
    """A spread of 1e-11 has an error of 2e-12, and what is five of these off is wrong; one of 1e-14 is rounding."""
    spread = np.random.default_rng(1).normal(size=32)
    noisy, still = 0.3 + 1e-11 * (spread - spread.mean()), 0.3 + 1e-14 * spread
    assert law_of(noisy, 0.3 + 1e-13).holds(LEVEL) and not law_of(noisy, 0.3 + 1e-11).holds(LEVEL)
    assert 1e-11 < law_of(noisy, 0.3).smallest_bias(LEVEL) < 1e-10 and law_of(noisy, 0.3 + 1e-13).z != 0
    assert law_of(still, 0.3 + 1e-13).holds(LEVEL) and not law_of(still, 0.3 + 1e-12).holds(LEVEL)
    assert law_of([0.3] * 32, 0.3 + 2e-13).z == 0 and not law_of([0.3] * 32, 0.3 + 1e-12).holds(LEVEL)


def test_counts_that_are_alike_by_chance_are_no_law_without_noise():
    """Three scores in each of 32 batches of a thousand, where 0.0031 is exact: unknown, as before."""
    law = law_of([0.003] * 32, 0.0031)
    assert not law.holds(LEVEL) and math.isnan(law.z) and math.isnan(law.smallest_bias(LEVEL))


def test_without_noise_what_few_histories_do_may_be_unseen():
    """All came through in 32 000 histories: a share that would not is seen in 95 % of the runs from 9.4e-5 on."""
    law = law_of([1.0] * 32, 1.0)
    bias = law.smallest_bias(LEVEL)
    assert (1 - bias) ** 32_000 == pytest.approx(0.05, rel=1e-3)
    assert law_of([0.2] * 2, 0.2, size=2**60).smallest_bias(LEVEL) == 1e-12


def test_without_a_known_error_no_law_holds_but_zero_where_nothing_can_arrive():
    assert not law_of([1.0], 1.0, size=100).holds(LEVEL) and not law_of([0.0], 1.0, size=100).holds(LEVEL)
    assert law_of([0.0, 0.0], 0.0, size=100, counts=0).holds(LEVEL)
    assert math.isnan(z_score(law_of([0.2] * 2, 0.2).estimate, math.nan))


@pytest.mark.slow
def test_smallest_bias_is_the_judges_own_and_is_caught_as_often_as_promised():
    rng, seeds, level = np.random.default_rng(11), 3000, LEVEL
    law = Law("", "", "", "", _estimate(rng, 1.0), 1.0)
    assert math.isclose(law.smallest_bias(level), agreement.smallest_bias(law.estimate, level), rel_tol=0.05)
    # for the spread that the error estimates
    true_bias = law.smallest_bias(level) / law.estimate.error * 0.01
    caught = sum(
        not Law("", "", "", "", _estimate(rng, 1 + true_bias), 1.0).holds(level) for _ in range(seeds)
    )
    assert min(bdtr(caught, seeds, 0.95), bdtrc(caught - 1, seeds, 0.95)) > 1e-5, (
        f"{caught} of {seeds} caught"
    )


def _estimate(rng, mean):
    """Of 32 batches, with a standard error of 0.01."""
    return Estimate(rng.normal(mean, 0.01 * math.sqrt(32), 32), Batches(np.full(32, 100)), "W")


@pytest.mark.parametrize(
    ("text", "formula", "source"),
    [
        ("T = exp(-k d)", "T = exp(-k d)", ""),
        ("T = exp (-k d)", "T = exp (-k d)", ""),
        ("T = exp(-k d) (Bouguer 1729)", "T = exp(-k d)", "Bouguer 1729"),
        ("T = exp(-k d) (my notes)", "T = exp(-k d) (my notes)", ""),
        ("T = (1 - R) (1 + R/2000)", "T = (1 - R) (1 + R/2000)", ""),
        ("φ = Φ/4πr² (van de Hulst, table 35)", "φ = Φ/4πr²", "van de Hulst, table 35"),
        ("R + T = 1; E = π L", "R + T = 1; E = π L", ""),
        ("E = π L sin²θ (Foote 1915)", "E = π L sin²θ", "Foote 1915"),
        ("P = π L A, L = f(θ) (Walsh (1958), p. 3).", "P = π L A, L = f(θ)", "Walsh (1958), p. 3"),
        ("J = n v / 4; Reif 1965, 7.11", "J = n v / 4", "Reif 1965, 7.11"),
        ("L is constant", "L is constant", ""),
    ],
)
def test_a_law_is_split_into_formula_and_source(text, formula, source):
    assert split_law(text) == (formula, source)


# Hard cases, beside the value of the naive formula

NOISY = Estimate([1.0, 1.1, 0.9, 1.05, 0.95], Batches([10] * 5), "1")


def case_of(found, naive=0.0, run=None):
    return Case(
        "spheres", "a sphere far away", "1 - cos θ", "It rounds to 0.",
        run or (lambda: CaseResult(found, 1.0, naive)),
    )  # fmt: skip


@pytest.fixture
def hard(call, monkeypatch):
    """Call `verify --hard` with these cases alone."""

    def verify(*made, more=()):
        monkeypatch.setattr("transport.cli.verify.cases_of", lambda families: iter(made))
        monkeypatch.setattr("transport.cli.verify.family_title", lambda name: f"All about {name}.")
        return call("verify", "--hard", *more)

    return verify


def test_hard_cases_are_printed_with_the_value_of_the_naive_formula(hard):
    answer = hard(case_of(1.0, math.nan), case_of(1.0, None), case_of(NOISY), case_of(1.0, 1.00010001))
    assert answer.exit_code == 0, answer.output
    assert "All about spheres." in answer.output and "4 of 4 hard cases hold" in answer.output
    assert all(words in answer.output for words in ("NaN", "–", "1.00 ± 0.04", "1.0001"))
    (record,) = json.loads(hard(case_of(1.0), more=["--json"]).stdout)
    assert record["reason"] == "It rounds to 0." and record["naive_value"] == 0 and record["holds"] is True


@pytest.mark.parametrize("found", [1 + 1e-9, math.nan, NOISY * 2])
def test_a_hard_case_that_fails_is_printed(hard, found):
    answer = hard(case_of(found), case_of(1.0))
    assert answer.exit_code == 1 and "1 of 2 hard cases hold" in answer.output and "FAILS" in answer.output


def test_an_interruption_that_a_case_handled_ends_the_verification_too(hard, press_ctrl_c):
    """A run within the case ends early for Ctrl-C, and its result is not printed."""

    def cut_short():
        with suppress(KeyboardInterrupt):
            press_ctrl_c()
        return CaseResult(2.0, 1.0, 0.0)

    answer = hard(case_of(1.0), Case("spheres", "cut short", "", "", cut_short), case_of(1.0))
    assert answer.exit_code == 130 and "the rows are incomplete" in answer.output
    assert "1 of 1 hard cases hold" in answer.output and "cut short" not in answer.output
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_cases_go_on_where_ctrl_c_is_ignored(hard):
    """As under nohup."""
    with pressing_ctrl_c(signal.SIG_IGN) as press:
        answer = hard(case_of(1.0, run=lambda: press() or CaseResult(1.0, 1.0, 0.0)))
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    assert answer.exit_code == 0 and "1 of 1 hard cases hold" in answer.output


@pytest.mark.parametrize("option", [("--seed", "1"), ("--particles", "10"), ("--threads", "2")])
def test_hard_cases_take_no_settings(hard, option):
    answer = hard(case_of(1.0), more=option)
    words = " ".join(answer.output.split())
    assert answer.exit_code == 2 and "leave out --particles, --seed, --threads" in words


def test_unknown_families_are_refused(call):
    answer = call("verify", "--hard", "direction")
    assert answer.exit_code == 2 and "did you mean 'directions'?" in answer.output
    assert "directions" in cases.families() and "cases" not in cases.families()


def test_a_name_of_both_an_experiment_and_a_family_is_the_experiment():
    assert "directions" in cases.families()
    [module] = verify.experiment_modules(["directions"])
    assert callable(module.scene)


# Weak rows, and rows without a score


def made_law(values, exact, quantity="flux"):
    run = Batches(np.full(len(values), 1000))
    return Law("law", "", "sim", quantity, Estimate(np.array(values), run, "W"), exact)


def noisy(spread):
    """32 batches about 1 of that relative standard error."""
    values = np.resize([1.0, -1.0], 32) * spread * math.sqrt(31)
    return 1 + values


@pytest.mark.parametrize(
    ("spread", "exact", "quantity", "state"),
    [
        (0.001, 1.0, "flux", "holds"),
        (0.012, 1.0, "flux", "weak"),  # a bias of 8 % would pass
        (0.012, 1.0, "χ²/(K − 1)", "holds"),  # whose bias is not one of a law
        (0.001, 1.1, "flux", "FAILS"),
        (0.012, 2.0, "flux", "FAILS"),
    ],
)
def test_a_row_that_a_bias_of_five_percent_passes_is_weak(spread, exact, quantity, state):
    law = made_law(noisy(spread), exact, quantity)
    assert law.estimate.error == pytest.approx(spread, rel=0.01)
    assert law.state(1e-6) == state


def test_a_row_without_a_score_does_not_hold():
    dark = made_law(np.zeros(32), 0.0)
    assert math.isnan(dark.z) and dark.state(1e-6) == "no score"
    record = verify.law_record(dark, 1e-6)
    assert record["holds"] is None and record["state"] == "no score"
    lit = made_law(np.zeros(32), 1.0)  # nothing came, though something should
    assert lit.state(1e-6) == "FAILS" and verify.law_record(lit, 1e-6)["holds"] is False


BELOW_AND_ABOVE = """
import math
import transport as tp

def scene():
    above, below = (tp.Disk(center=(0, 0, z), normal=(0, 0, -z), radius=0.2) for z in (1, -1))
    lamp = tp.Source(tp.Point(), tp.Isotropic(power=1.0))
    both = tp.Detector(above, "both", via="below")
    return tp.Scene(lamp, detectors=[tp.Detector(above, "above"), tp.Detector(below, "below"), both])

def measure(result):
    rows = {name: result[name].flux_in for name in result}
    return rows | {"shape of χ²": rows["below"]}

def exact():
    share = (1 - 1 / math.hypot(1, 0.2)) / 2
    return {"above": share, "below": share, "shape of χ²": share, "both": 0.0}
"""


def test_verify_counts_weak_rows_and_those_without_a_score(call):
    """One ray in a hundred meets a disk; none flies both up and down."""
    Path("mine.py").write_text(BELOW_AND_ABOVE, encoding="utf-8")
    arguments = ["verify", "mine.py", "--particles", "100000"]
    rows = {row["quantity"]: row for row in json.loads(call(*arguments, "--json").stdout)}
    states = {name: row["state"] for name, row in rows.items()}
    assert states == {"above": "weak", "below": "weak", "both": "no score", "shape of χ²": "holds"}
    assert rows["both"]["z"] is None and rows["both"]["holds"] is None
    answer = call(*arguments)
    words = " ".join(answer.output.split())
    assert answer.exit_code == 0
    assert "3 of 4 rows hold, 1 has no score, as expected" in words
    assert "weak: 2 of 4 rows hold even with a bias of 5%" in words
    assert "1 row compares a shape: its bias is of χ², not of a law" in words


# The long proof


@pytest.fixture
def proof(call, monkeypatch):
    """All experiments, which are the disks, and these hard cases."""
    monkeypatch.setattr(verify, "experiment_names", lambda: ["disks.py"])

    def prove(*made, more=()):
        monkeypatch.setattr(verify, "cases_of", lambda: list(made))
        return call("verify", "--long", "--particles", "20000", *more)

    return prove


def test_the_long_proof_is_one_table_after_an_estimate_of_its_time(proof):
    answer = proof(case_of(1.0), case_of(1.0))
    assert answer.exit_code == 0, answer.output
    first = answer.stderr.splitlines()[1]
    assert first.startswith("experiments: 1, with 2e+04 particles per case; hard cases: 2; about ")
    lines = [line.split() for line in answer.stdout.splitlines()]
    assert ["disks", "2", "2", "2"] in [line[:4] for line in lines]
    assert ["hard:", "spheres", "2", "2", "2"] in lines
    assert "4 of 4 rows and hard cases hold" in answer.stdout and ", estimated " in answer.stdout
    record = json.loads(proof(case_of(1.0), more=["--json"]).stdout)
    assert record["particles"] == 20000 and record["foreseen_seconds"] > 0
    assert [row["holds"] for row in (*record["laws"], *record["hard"])] == [True] * 3


def test_failing_rows_of_the_long_proof_are_printed_in_full(proof, call):
    answer = proof(case_of(1.0), case_of(1.1))
    assert answer.exit_code == 1
    assert "3 of 4 rows and hard cases hold" in answer.stdout and answer.stdout.count("FAILS") == 1
    answer = call("verify", "--long", "wrong.py", "--particles", "2000")
    assert answer.exit_code == 1 and "hard cases: 0;" in answer.stderr
    assert "irradiance" in answer.stdout and "0 of 1 rows" in answer.stdout


@pytest.mark.parametrize(("how", "first"), [(["--long"], 6), ([], 2)], ids=["long", "plain"])
def test_rows_known_at_an_interruption_are_printed(call, monkeypatch, how, first):
    """Ctrl-C before the first batch of the second case; the long proof has had two pilots of both cases."""
    from transport.simulate import simulate_all_quantities as simulate

    calls = count(1)

    def interrupted(*arguments, **limits):
        if next(calls) == first:
            raise KeyboardInterrupt
        return simulate(*arguments, **limits)

    monkeypatch.setattr("transport.verification.experiment.simulate_all_quantities", interrupted)
    answer = call("verify", "disks.py", "--particles", "2000", *how)
    assert answer.exit_code == 130
    assert "1 of 1 rows" in answer.stdout and "the rows are incomplete" in answer.stderr


@pytest.mark.parametrize(
    "arguments", [["--particles", "0"], ["good.py", "nowhere.py"], ["--hard"], ["geometry"]]
)
def test_input_of_the_long_proof_is_refused_before_the_pilots(call, monkeypatch, arguments):
    monkeypatch.setattr(verify, "run_until_interrupt", None)
    Path("good.py").write_text(EXPERIMENT, encoding="utf-8")
    answer = call("verify", "--long", *arguments)
    assert answer.exit_code == 2 and answer.output.count("error: ") == 1, answer.output
