"""Pictures in notebooks: one tone map for all, the difference on a symmetric scale, clear refusals."""

import numpy as np
import pytest

import mcdenoise as mcd
from conftest import noise
from mcdenoise.study.display import tone_map
from mcdenoise.study.show import NOT_FINITE, displayed


def _images(figure):
    return [axes.images[0].get_array() for axes in figure.axes if axes.images]


def test_all_images_get_the_same_tone_map():
    dark, bright = 0.1 * noise(6, 5, 3), 2 * noise(6, 5, 3, seed=4)
    shown = _images(mcd.show_images({"dark": dark, "bright": bright}))
    np.testing.assert_array_equal(shown[0], tone_map(dark))
    np.testing.assert_array_equal(shown[1], tone_map(bright))


def test_grey_images_are_shown_grey_and_not_stretched():
    for grey in (np.full((4, 4), 0.25), np.full((4, 4, 1), 0.25)):
        (shown,) = _images(mcd.show_images({"grey": grey}))
        assert shown.shape == (4, 4, 3)
        np.testing.assert_array_equal(shown, tone_map(np.full((4, 4, 3), 0.25)))


def test_images_stand_in_rows_under_their_titles():
    figure = mcd.show_images({name: np.zeros((3, 3)) for name in "abcde"}, title="five", columns=2)
    assert [axes.get_title() for axes in figure.axes] == list("abcde")
    assert figure.get_suptitle() == "five"
    assert len({axes.get_position().x0 for axes in figure.axes}) == 2


def test_a_long_title_wraps():
    (axes,) = mcd.show_images({"a title that is far too long to stand above one picture": np.zeros((3, 3))}).axes
    assert max(len(line) for line in axes.get_title().splitlines()) <= 38


def test_the_inputs_stay_as_they_were():
    yours, target = noise(5, 5, 3), noise(5, 5, 3, seed=9)
    copies = yours.copy(), target.copy()
    mcd.show_difference(yours, target)
    mcd.show_images({"yours": yours})
    np.testing.assert_array_equal(yours, copies[0])
    np.testing.assert_array_equal(target, copies[1])


def test_the_difference_is_signed_and_its_scale_symmetric():
    target = np.full((4, 4, 3), 0.5)
    yours = target.copy()
    yours[1, 2] += 0.25
    yours[3, 0] -= 0.125
    scale = mcd.show_difference(yours, target).axes[2].images[0]
    assert scale.get_array()[1, 2] == pytest.approx(0.25)
    assert scale.get_array()[3, 0] == pytest.approx(-0.125)
    assert scale.get_clim() == (-0.25, 0.25)


def test_equal_images_have_no_difference_and_rounding_is_none():
    target = noise(4, 4)
    for yours in (target, target * (1 + 1e-12)):
        axes = mcd.show_difference(yours, target).axes[2]
        assert axes.get_title() == "yours - target: no difference"
        assert axes.images[0].get_clim() == (-1, 1)


def test_values_that_are_not_finite_are_marked():
    target = np.full((4, 4, 3), 0.5)
    yours = target.copy()
    yours[0, 1, 2], yours[2, 2, 0] = np.nan, np.inf
    left, _, right = mcd.show_difference(yours, target).axes[:3]
    assert "2 pixels not finite" in left.get_title()
    np.testing.assert_allclose(left.images[0].get_array()[0, 1], NOT_FINITE)
    assert right.images[0].get_array().mask.sum() == 2


def test_a_notebook_shows_the_figure():
    assert mcd.show_images({"a": np.zeros((3, 3))})._repr_png_().startswith(b"\x89PNG")


@pytest.mark.parametrize("images", [{}, [np.zeros((3, 3))], np.zeros((3, 3))])
def test_images_come_with_their_titles(images):
    with pytest.raises(ValueError, match=r"dict of title -> image with at least one image"):
        mcd.show_images(images)


@pytest.mark.parametrize("columns", [0, 1.5])
def test_columns_are_counted_from_one(columns):
    with pytest.raises(ValueError, match="columns must be a whole number of at least 1"):
        mcd.show_images({"a": np.zeros((3, 3))}, columns=columns)


def test_a_refused_image_is_named():
    with pytest.raises(ValueError, match="image 'broken' must be finite"):
        mcd.show_images({"fine": np.zeros((3, 3)), "broken": np.full((3, 3), np.nan)})
    with pytest.raises(ValueError, match=r"samples must have 1 or 3 channels to be shown, got shape \(3, 3, 2\)"):
        displayed(np.zeros((3, 3, 2)), "samples")


def test_a_difference_needs_two_images_of_one_shape():
    with pytest.raises(ValueError, match=r"yours must have the height and width of target, \(3, 3\), got \(3, 4\)"):
        mcd.show_difference(np.zeros((3, 4)), np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"yours must have the shape of target, \(3, 3, 3\), got \(3, 3\)"):
        mcd.show_difference(np.zeros((3, 3)), np.zeros((3, 3, 3)))
