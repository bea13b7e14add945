"""Array descriptions: chips to frames and back, thresholds, and errors in a file."""

import numpy as np
import pytest

from cnnsim.support import InputError
from tactile.settings import PipelineOptions
from tactile.thresholds.levels import SIGMAS, Sigmas
from tactile.thresholds.threshold import SIGN, Threshold
from tactile.wire.arrange import Arrange, back
from tactile.wire.description_file import default_description, parse_description
from tactile.wire.packets import emulated_description, packets
from tactile.wire.reading import Reading
from tactile.wire.source import WireSource
from tests.kits.serial import grip, sent

TEXT = """
title = "hand"
protocol = "reskin"
youngs_modulus_mpa = 0.4
[[finger]]
name = "thumb"
rows = 2
cols = 3
pitch_mm = 7.0
depth_mm = 2.0
quantity = "strain"
axes = ["-y", "x", "-z"]
gains = [1e-5, 2e-5]
cells = [[-1, 1, 3], [2, 0, -1]]
"""


def test_a_description_maps_chips_to_frames_and_back() -> None:
    description = parse_description(TEXT, "here")
    assert description.options.shapes == ((1, 4),)
    chips = np.arange(12.0).reshape(4, 3) + 1
    (frame,) = Arrange(description)(Reading(chips, 66), 1.5)
    assert frame.valid.tolist() == [[False, True, True], [True, True, False]]
    x, y, z = chips[0]
    assert frame.values[1, 1] == pytest.approx([-y * 1e-5, x * 1e-5, -z * 2e-5], rel=1e-12)
    assert back(frame, description.boards[0]) == pytest.approx(chips, rel=1e-12)
    assert (description.modulus, description.baudrate) == (400000.0, 115200)
    again = parse_description(description.text, "again")
    assert again.arrays == description.arrays


@pytest.mark.parametrize(("change", "message"), [
    (('"reskin"', '"risken"'), "one of reskin"),
    (("title", "titel"), "did you mean 'title'"),
    (('["-y", "x", "-z"]', '["x", "x", "z"]'), "each of x, y, z once"),
    (('["-y", "x", "-z"]', '["x"]'), "each of x, y, z once"),
    (("[1e-5, 2e-5]", "[0, 1]"), "shear gain 0.0"),
    (("[[-1, 1, 3]", "[[-1, 1, 4]"), "chip numbers 0, 1"),
    (("[[-1, 1, 3], ", "["), "2 x 3 chip numbers"),
    (("rows = 2", "rows = 0"), "rows = 0, a whole number from 1 up"),
    (('protocol = "reskin"', 'protocol = "reskin"\\nbaudrate = 0'), "baudrate = 0, a whole number from 1 up wanted"),
    (("[[finger]]", "[options]\\nvalue = 1\\n[[finger]]"), "unknown key 'value'"),
    (("depth_mm = 2.0", "depth_mm = 2.0\\nthickness_mm = 1.5"), "a cover 0.0015 m thick over taxels 0.002 m deep"),
    (("0.4", "0..4"), "not TOML"),
])  # fmt: skip
def test_wrong_descriptions_are_refused(change: tuple[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_description(TEXT.replace(change[0], change[1].replace("\\n", "\n")), "here")


THRESHOLDS = """
[thresholds]
dead_band = 0.2
contact_level = 0.05
sigmas = [5, 6, 7]
"""


def test_thresholds_come_from_the_options_then_the_file_then_the_defaults() -> None:
    source = WireSource(parse_description(TEXT + THRESHOLDS, "here"), ())
    from_file = PipelineOptions().settings(source)
    assert from_file.shear == Threshold(0.2, 0.1)
    assert from_file.contact == Threshold(0.05, 0.025)
    assert from_file.sigmas == Sigmas(5, 6, 7)
    given = PipelineOptions(hysteresis=0.3, sigmas=(0.0, 0.0, 0.0)).settings(source)
    assert (given.shear, given.sigmas, given.contact) == (Threshold(0.2, 0.3), Sigmas(0, 0, 0), from_file.contact)
    assert PipelineOptions(dead_band=0.0).settings(source).shear == SIGN
    assert PipelineOptions(sign_code=True).settings(source).shear == SIGN
    signs = WireSource(parse_description(TEXT + "[thresholds]\nsign_code = true\n", "here"), ())
    assert PipelineOptions().settings(signs).shear == SIGN
    assert PipelineOptions(dead_band=1.0).settings(signs).shear == Threshold(1.0, 0.5)
    plain = PipelineOptions().settings(WireSource(parse_description(TEXT, "here"), ()))
    assert (plain.shear, plain.contact, plain.sigmas) == (None, None, SIGMAS)
    with pytest.raises(InputError, match="hysteresis needs a dead_band"):
        PipelineOptions(hysteresis=0.3).settings(WireSource(parse_description(TEXT, "here"), ()))


def test_all_faults_of_thresholds_are_reported_with_their_lines() -> None:
    wrong = TEXT.replace("title", "titel") + (
        "[thresholds]\ndead_bnad = 1\nhysteresis = -0.1\ncontact_level = true\nsigmas = [1, -2, 3]\nsign_code = 1\n"
    )
    with pytest.raises(InputError) as caught:
        parse_description(wrong, "here")
    for fault in (
        "unknown key 'titel' (line 2)", "[thresholds]: unknown key 'dead_bnad' (line 16); did you mean 'dead_band'?",
        "[thresholds]: hysteresis = -0.1, a number from 0 wanted (line 17)",
        "[thresholds]: contact_level = True, a finite number wanted (line 18)",
        "[thresholds]: sigmas: hysteresis of -2.0 sigma; a number from 0 wanted (line 19)",
        "[thresholds]: sign_code = 1, true or false wanted (line 20)",
    ):  # fmt: skip
        assert fault in str(caught.value)
    for text, message in (
        ("[thresholds]\nhysteresis = 1\n", r"hysteresis needs a dead_band.* \(line 15\)"),
        ("[thresholds]\nsign_code = true\ndead_band = 1\n", r"sign_code has no dead band.* \(line 15\)"),
    ):
        with pytest.raises(InputError, match=message):
            parse_description(TEXT + text, "here")
    with pytest.raises(InputError, match=r"thresholds.*a table wanted"):
        parse_description("thresholds = 3\n" + TEXT, "here")
    other = TEXT.split("[[finger]]")[1].replace('"thumb"', '"tip"').replace('"strain"', '"force"')
    with pytest.raises(InputError, match=r"levels for fingers of force and strain.*\(line 26\)"):
        parse_description(TEXT + "[[finger]]" + other + THRESHOLDS, "here")


def test_default_descriptions_and_the_shapes_a_device_can_send() -> None:
    assert [array.shape for array in default_description("papillarray").arrays] == [(3, 3), (3, 3)]
    with pytest.raises(InputError, match="--array FILE wanted"):
        default_description("reskin")
    plain = parse_description(TEXT.replace("gains", "#"), "here")
    with pytest.raises(InputError, match="gains"):
        plain.check_calibrated()
    parse_description(TEXT, "here").check_calibrated()
    with pytest.raises(InputError, match="carries one array"):
        emulated_description("paxini-serial", grip(0.1))
    description, _ = sent("native", 0.1)
    with pytest.raises(InputError, match="has arrays of 2 x 2; the array description has 2 x 2 and 2 x 2"):
        packets(description, grip(0.1, 1))
