"""The package as a whole."""

import glanz


def test_version_is_that_of_the_program() -> None:
    assert glanz.__version__.count(".") == 2
