"""What the driller reads: right, plain, and nothing that must not be trusted in large figures."""

import pytest

from tests.view_rig import estimate, status
from vsensor.messages import Estimate, Status
from vsensor.messages.vsensor_pb2 import BAD
from vsensor.quality import Reason
from vsensor.view.words import health, panel, silence


def test_the_panel_leads_with_the_bit_and_how_rough_it_runs() -> None:
    head, second, *rest = panel(estimate(100), status()).split("\n\n")
    assert head == "# Bit 191 rpm, 3.1 kN·m"
    assert second == "# STICK-SLIP, severity 1.20"
    assert "| now | 191 ± 8 rpm | 3.1 ± 0.4 kN·m |" in rest[0]
    assert "| 1.2 s ago | 0 ± 2 rpm | 3.0 ± 0.2 kN·m |" in rest[0]
    assert "(max − min) / (2 mean)" in rest[-1]


@pytest.mark.parametrize(
    ("severity", "verdict"),
    [(0.0, "Smooth"), (0.49, "Smooth"), (0.5, "Uneven"), (0.99, "Uneven"), (1.0, "STICK-SLIP")],
)
def test_the_severity_is_told_in_a_word(severity: float, verdict: str) -> None:
    assert f"# {verdict}, severity {severity:.2f}" in panel(estimate(0), Status(severity=severity))


def test_an_unknown_severity_is_no_smooth_one() -> None:
    assert "# Stick-slip not known yet" in panel(estimate(0), Status())


def test_a_bad_estimate_is_not_shown_in_large_figures_and_says_why() -> None:
    bad = estimate(100)
    bad.quality = BAD
    bad.reasons = int(Reason.STALE_TORQUE | Reason.WARMING_UP)
    text = panel(bad, status("input lost"))
    assert text.startswith("# Bit not known: input lost")
    assert "bad (warming up, stale torque)" in text


def test_before_anything_is_known_nothing_is_claimed() -> None:
    text = panel(Estimate(), Status())
    assert "Bit not known: no status yet" in text
    assert "estimate **not known**" in text


def test_a_verdict_of_a_newer_daemon_is_not_trusted() -> None:
    strange = estimate(100)
    strange.MergeFromString(bytes([0x88, 0x01, 9]))  # field 17, quality = 9
    assert panel(strange, status()).startswith("# Bit not known")


def test_every_count_of_something_lost_is_told() -> None:
    text = health(status(), missed=11)
    for line in (
        "| received | 990 |",
        "| lost | **7** |",
        "| late | **4** |",
        "| jumped | 0 |",
        "| bad at source | 0 |",
        "| slots skipped by the loop, of 1000 | **3** |",
        "| restarts of the estimator | **2** |",
        "| messages that the recorder could not take | **5** |",
        "| ticks that this view has missed | **11** |",
        "| lateness | 40 µs | 120 µs |",
    ):
        assert line in text
    assert "Recording: none" in text


def test_silence_is_told_with_its_length() -> None:
    assert silence(61.7).startswith("# No word for 62 s")
