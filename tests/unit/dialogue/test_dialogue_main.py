"""The command line of the dialogue."""

import pytest

from w2c_dialogue.__main__ import main


@pytest.mark.parametrize(
    "arguments", [["--robot", "talos", "--nonsense"], ["--robot", "talos", "--prompts", "tiny"]]
)
def test_unknown_flags_and_values_exit_with_2(arguments: list[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2


def test_a_value_out_of_bounds_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--robot", "talos", "--model-timeout", "-1"]) == 2
    assert "model_timeout" in capsys.readouterr().err
