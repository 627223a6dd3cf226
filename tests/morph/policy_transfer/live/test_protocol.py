from __future__ import annotations

import json
import math
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from morph.errors import TransferError
from morph.policy_transfer.live.protocol import (
    SCHEMA,
    Hello,
    Signal,
    hello_of,
    hello_said,
    number,
    parsed,
)

HELLO = Hello(
    channels=(Signal(name="hinge.position", unit="rad"),),
    actuators=(Signal(name="slide", unit="N"),),
    period=0.05,
)

VALUES = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)


def test_what_a_target_says_of_itself_is_read_as_it_was_written() -> None:
    assert hello_of(json.loads(json.dumps(hello_said(HELLO))), where="target") == HELLO


@pytest.mark.parametrize(
    ("part", "value", "says"),
    [
        ("schema", "morph.live/2", r"its schema is 'morph.live/2'"),
        ("period_s", 0.0, r"its period_s is 0.0, not 1e-4 to 10 s"),
        ("period_s", True, r"its period_s is True"),
        ("clock", "mine", r"its clock is 'mine', not one of target, none"),
        ("channels", [], r"its channels are \[\], not a list"),
        ("channels", [{"name": "x"}], r"lacks a name or a unit"),
        ("actuators", [{"name": "a", "unit": "N"}] * 2, r"its actuators name a twice"),
        ("actuators", [{"name": "a" * 300, "unit": "N"}], r"too long a name"),
    ],
)
def test_a_first_message_that_is_none_is_refused(part: str, value: object, says: str) -> None:
    with pytest.raises(TransferError, match=says):
        hello_of({**hello_said(HELLO), part: value}, where="target")


@settings(max_examples=100, deadline=None)
@given(said=st.dictionaries(st.sampled_from(["channels", "period_s", "clock"]), VALUES))
def test_no_first_message_does_more_than_to_be_refused(said: dict[str, object]) -> None:
    # Any other error than this would fail the test.
    with suppress(TransferError):
        assert isinstance(hello_of({**hello_said(HELLO), **said}, where="target"), Hello)


@settings(max_examples=200, deadline=None)
@given(line=st.binary(max_size=60))
def test_any_line_is_an_object_or_none(line: bytes) -> None:
    assert isinstance(parsed(line), dict | None)


@pytest.mark.parametrize("line", [b"[" * 50_000, b"9" * 50_000, b"\xff", b"", b"[1]", b"nul"])
def test_a_line_that_is_no_object_is_none(line: bytes) -> None:
    assert parsed(line) is None


@pytest.mark.parametrize("value", [None, True, "1", [1], math.nan, math.inf, -(10**400)])
def test_what_is_no_finite_number_is_nan(value: object) -> None:
    assert math.isnan(number(value))


def test_the_schema_is_the_one_that_the_page_names() -> None:
    assert SCHEMA == "morph.live/1"
