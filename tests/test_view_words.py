"""What is read: right, plain, and in the units that were asked for."""

from tests.view_rig import estimate, status, stuck
from vsensor.messages import Estimate, Event, Status
from vsensor.view.units import Units
from vsensor.view.words import answers, health, silence, told


def test_the_answers_stand_with_their_times_and_deviations_in_the_units_asked_for() -> None:
    text = answers(estimate(100), status(), Units())
    assert "| now | 191 ± 8 rpm | 3.1 ± 0.4 kN·m |" in text
    assert "| 1.2 s ago | 0 ± 2 rpm | 3.0 ± 0.2 kN·m |" in text
    assert "(max − min) / (2 mean)" in text
    other = answers(estimate(100), status(), Units("rad/s", "kft*lbf"))
    assert "| now | 20.0 ± 0.8 rad/s | 2.3 ± 0.3 kft·lbf |" in other


def test_before_anything_is_known_nothing_is_claimed() -> None:
    assert answers(Estimate(), Status(), Units()).count("not known") == 6


def test_an_event_is_told_with_its_time_and_whether_it_ends() -> None:
    assert told(stuck(0, True)) == ("WARN", "22:13:20 stuck: the bit stands still")
    assert told(stuck(150, False)) == ("INFO", "22:13:21 stuck ends: the bit stands still")


def test_what_was_refused_has_not_ended() -> None:
    refused = Event(time_ns=0, name="configuration", begins=False, text="the file has faults")
    assert told(refused) == ("WARN", "00:00:00 configuration refused: the file has faults")


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
