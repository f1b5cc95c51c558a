"""EXR in and out: what is written comes back, and what is no EXR is told apart."""

import numpy as np
import pytest

from mcdenoise.render import read_exr, write_exr

pytestmark = pytest.mark.ch01


@pytest.mark.parametrize("shape", [(4, 6), (4, 6, 2), (4, 6, 3), (4, 6, 4), (4, 6, 12), (1, 1, 3)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_round_trip(tmp_path, rng, shape, dtype):
    image = rng.normal(size=shape).astype(dtype) * 1e3
    write_exr(tmp_path / "image.exr", image)
    back = read_exr(tmp_path / "image.exr")
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, image.astype(np.float32))


def test_layers(tmp_path, rng):
    layers = {"": rng.random((3, 5, 3)), "albedo": rng.random((3, 5, 3)), "visibility": rng.random((3, 5))}
    write_exr(tmp_path / "layers.exr", layers)
    for name, values in layers.items():
        np.testing.assert_array_equal(read_exr(tmp_path / "layers.exr", name or None), values.astype(np.float32))


def test_layer_must_be_chosen(tmp_path):
    write_exr(tmp_path / "layers.exr", {"albedo": np.ones((2, 2, 3)), "depth": np.ones((2, 2))})
    for layer in (None, "normal"):
        with pytest.raises(ValueError, match=r"has no layer .*; choose one with layer=: albedo, depth"):
            read_exr(tmp_path / "layers.exr", layer)
    write_exr(tmp_path / "single.exr", {"albedo": np.full((2, 2, 3), 0.5)})
    assert (read_exr(tmp_path / "single.exr") == 0.5).all()


def test_file_of_another_program(tmp_path, rng):
    """Half floats and channels out of order, as other renderers write them."""
    from mcdenoise.render.variants import use_variant

    image = rng.random((4, 6, 3)).astype(np.float32)
    with use_variant("scalar_rgb"):
        import mitsuba as mi

        names = ["left.B", "left.R", "left.G"]
        bitmap = mi.Bitmap(image.astype(np.float16), mi.Bitmap.PixelFormat.MultiChannel, names)
        bitmap.write(str(tmp_path / "other.exr"))
    np.testing.assert_array_equal(read_exr(tmp_path / "other.exr"), image[..., [1, 2, 0]].astype(np.float16))


def test_nonfinite_pixels(tmp_path):
    from mcdenoise.render.variants import use_variant

    image = np.array([[1.0, np.nan, np.inf]], np.float32)
    with pytest.raises(ValueError, match="image must be finite: 2 of 3 values"):
        write_exr(tmp_path / "image.exr", image)
    with use_variant("scalar_rgb"):
        import mitsuba as mi

        mi.Bitmap(image).write(str(tmp_path / "image.exr"))
    with pytest.raises(ValueError, match=r"image\.exr must be finite: 2 of 3 values"):
        read_exr(tmp_path / "image.exr")
    np.testing.assert_array_equal(read_exr(tmp_path / "image.exr", nonfinite="zero"), [[1, 0, 0]])


@pytest.mark.parametrize(
    ("image", "message"),
    [
        (np.ones(3), r"image must have shape \(h, w\) or \(h, w, c\), got \(3,\)"),
        ({}, "image must name at least one layer, got an empty mapping"),
        ({"a.b": np.ones((2, 2))}, r"A layer's name must be a plain word or '', got 'a\.b'"),
        ({"a": np.ones((2, 2)), "b": np.ones((2, 3))}, "b must have the height and width of the first layer"),
    ],
)
def test_bad_images_leave_the_old_file(tmp_path, image, message):
    write_exr(tmp_path / "image.exr", np.ones((2, 2)))
    with pytest.raises(ValueError, match=message):
        write_exr(tmp_path / "image.exr", image)
    assert (read_exr(tmp_path / "image.exr") == 1).all()
    assert [path.name for path in tmp_path.iterdir()] == ["image.exr"]


def test_bad_paths(tmp_path):
    with pytest.raises(ValueError, match=r"must be named \*\.exr, got 'image\.png'"):
        write_exr(tmp_path / "image.png", np.ones((2, 2)))
    with pytest.raises(ValueError, match=r"The folder .* must exist"):
        write_exr(tmp_path / "nowhere" / "image.exr", np.ones((2, 2)))
    with pytest.raises(ValueError, match="there is no file"):
        read_exr(tmp_path / "image.exr")
    (tmp_path / "image.exr").write_text("no image")
    with pytest.raises(ValueError, match=r"image\.exr can not be read as an image: "):
        read_exr(tmp_path / "image.exr")
