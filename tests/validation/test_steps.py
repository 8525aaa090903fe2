"""What is done of a document survives the process that did it, and what was lost is said and not tried for ever."""

from __future__ import annotations

import pickle

import pytest

from mrm_mtlx.system import process_limits
from mrm_mtlx.validation.steps import MAXIMUM_LOST, READING, Step, Steps, add_lost, lost_finding, read_record

GLSL, ESSL = Step("m", "glsl"), Step("m", "essl")


def said(found):
    return f"{found.code} {found.location} {found.message}"


@pytest.fixture
def record(tmp_path):
    return tmp_path / "0.steps"


def test_what_was_done_is_not_done_again_by_the_next_process(record):
    assert Steps(record).run(GLSL, lambda: 1, said) == 1
    assert Steps(record).run(GLSL, lambda: 2, said) == 1


def test_a_result_that_is_not_kept_is_made_again(record):
    assert Steps(record).run(GLSL, lambda: 1, said, kept=False) == 1
    assert Steps(record).run(GLSL, lambda: 2, said, kept=False) == 2


def test_the_step_in_which_a_process_died_is_known_and_stands_for_itself(record):
    first = Steps(record)
    first.run(GLSL, lambda: 1, said)
    first.begin(ESSL)
    assert read_record(record).begun == ESSL
    add_lost(record, ESSL, "not finished within 5 s", timed_out=True)
    second = Steps(record)
    assert second.run(ESSL, lambda: 2, said) == "CHECK_TIMEOUT /m essl: not finished within 5 s"
    assert second.run(GLSL, lambda: 2, said) == 1


def test_nothing_is_under_way_between_steps(record):
    Steps(record).run(GLSL, lambda: 1, said)
    assert read_record(record).begun is None


def test_each_step_has_its_time(record, monkeypatch):
    limits: list[float] = []
    monkeypatch.setattr(process_limits, "limit_time", limits.append)
    steps = Steps(record, 7.0)
    steps.run(GLSL, lambda: limits.append(0.0), said)
    steps.run(ESSL, lambda: 1, said)
    assert limits == [7.0, 0.0, 7.0]


def test_an_error_in_a_step_loses_that_step_alone(record):
    def fail():
        raise KeyError("x")

    steps = Steps(record)
    assert steps.run(GLSL, fail, said) == "CHECK_CRASHED /m glsl: internal error: KeyError: 'x'"
    assert steps.run(ESSL, lambda: 2, said) == 2
    assert Steps(record).run(GLSL, lambda: 1, said) == "CHECK_CRASHED /m glsl: internal error: KeyError: 'x'"


def test_memory_that_is_not_there_is_told_with_the_limit(record):
    def fail():
        raise MemoryError

    found = Steps(record).run(GLSL, fail, lambda found: found)
    assert found.message == f"glsl: {process_limits.memory_reason()}"


def test_without_a_record_an_error_is_raised():
    with pytest.raises(ZeroDivisionError):
        Steps().run(GLSL, lambda: 1 / 0, said)


def test_after_some_losses_the_rest_of_a_document_is_not_tried(record):
    for number in range(MAXIMUM_LOST):
        assert not Steps(record).skips(GLSL)
        add_lost(record, Step(f"m{number}", "glsl"), "died", timed_out=False)
    assert Steps(record).skips(GLSL)
    assert not Steps(record).skips(Step("m0", "glsl"))  # what is known of it is told


def test_a_record_that_ends_in_the_middle_of_an_entry_is_read_to_there(record):
    Steps(record).run(GLSL, lambda: 1, said)
    with record.open("ab") as stream:
        stream.write(pickle.dumps(("done", ESSL, list(range(100))))[:-20])
    assert Steps(record).run(GLSL, lambda: 2, said) == 1
    assert Steps(record).run(ESSL, lambda: 2, said) == 2


def test_a_document_that_cannot_be_read_in_time_has_no_part_to_name():
    assert said(lost_finding(READING, "not finished within 5 s", timed_out=True)) == (
        "CHECK_TIMEOUT  not finished within 5 s"
    )
