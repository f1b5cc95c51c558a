"""The exercises of chapter 08, back propagation: what holds for a right answer."""

import numpy as np

from mcdenoise.classroom import Finding, as_numbers, as_parts, assert_matches, central_differences, graded, name_mistake


def _short(values):
    return np.array2string(np.asarray(values), precision=3, separator=", ", threshold=12).replace("\n", "")


# --- used_twice


@graded("used_twice", points=1)
def test_gradients_of_a_small_graph(impl):
    "The gradients of g = (x + y)(x z) with respect to x, y and z; where a value goes two ways, both are added."
    values = as_numbers(impl)
    assert np.shape(values) == (3,), "three numbers are needed: dg/dx, dg/dy, dg/dz."
    x, y, z = -2.0, 5.0, -4.0
    q, p = x + y, x * z
    by_sum, by_product = p, q * z
    expected = np.array([by_sum + by_product, p, q * x])
    whole = {
        "that is f = (x + y) z of the example: g is another function": [-4, -4, 3],
        "all signs are flipped": -expected,
    }
    for words, wrong in whole.items():
        assert not np.allclose(values, wrong), f"{_short(values)}: {words}."
    hints = (
        ("dg/dx", by_sum, "only the way through q = x + y is counted; x goes into p = x z as well, add both"),
        ("dg/dx", by_product, "only the way through p = x z is counted; x goes into q = x + y as well, add both"),
        ("dg/dx", by_sum * by_product, "what comes by two ways is added, not multiplied"),
        ("dg/dx", by_sum - by_product, "what comes by two ways is added: mind the sign of z"),
        ("dg/dx", 1 + z, "local gradients alone: each is multiplied by what arrives from behind"),
        ("dg/dy", 1, "that is the local gradient: multiply it by what arrives at q, which is p"),
        ("dg/dy", q, "what arrives at q is the other factor, p, and not q itself"),
        ("dg/dz", x, "that is the local gradient: multiply it by what arrives at p, which is q"),
        ("dg/dz", p * x, "what arrives at p is the other factor, q, and not p itself"),
        ("dg/dz", q, "p = x z: dp/dz is x, multiply by it"),
    )
    for name, wrong, words in hints:
        place = ("dg/dx", "dg/dy", "dg/dz").index(name)
        assert values[place] != wrong or wrong == expected[place], f"{name} is not {wrong:g}: {words}."
    for place, name in enumerate(("dg/dx", "dg/dy", "dg/dz")):
        assert abs(values[place] - expected[place]) < 1e-9, (
            f"{name} is not {values[place]:g}: write values and local gradients of q = x + y, p = x z and g = q p into a table."
        )


# --- linear(x, weight, bias)


def _weight():
    """Three inputs, two outputs; a new array each time, since an answer may spoil what it gets."""
    return np.array([[2.0, -1.0, 4.0], [0.5, 3.0, -2.0]])


def _dot(one, other):
    return sum(float(a) * float(b) for a, b in zip(one, other, strict=True))


def _layer(x, weight, bias):
    """y, number by number."""
    return np.array([[_dot(row, one) + float(b) for one, b in zip(weight, bias, strict=True)] for row in x])


@graded("linear", points=1)
def test_a_layer_of_two_outputs(impl):
    "y_s = sum over t of w_{s,t} x_t + b_s, for each row of the batch."
    x, weight, bias = np.array([[1.0, 2.0, 0.5], [-1.0, 0.0, 3.0]]), _weight(), np.array([10.0, -20.0])
    expected, what = _layer(x, weight, bias), "y for two rows of three numbers, two outputs"
    found = impl(x, weight, bias)
    mistakes = {
        "the bias is missing": expected - bias,
        "the bias is subtracted": expected - 2 * bias,
        "the bias is added to rows in place of columns: bias s belongs to output s": expected
        - bias
        + bias[:, np.newaxis],
        "all biases are added to every output": expected - bias + bias.sum(),
        "transposed: a row for each row of x, a column for each output": expected.T,
        "only the first row of the batch": expected[0],
        "the sum over the batch; each row is an answer of its own": expected.sum(axis=0),
        "the bias is multiplied": (expected - bias) * bias,
    }
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)
    square, nothing = np.array([[1.0, 2.0], [3.0, 4.0]]), np.zeros(2)
    rows = np.array([[1.0, 0.0], [0.0, 1.0], [5.0, -1.0]])
    expected, what = _layer(rows, square, nothing), "y for a square weight"
    mistakes = {
        "the weight is not transposed: row s of it holds the weights of output s": np.array(
            [[_dot(row, column) for column in square.T] for row in rows]
        )
    }
    found = impl(rows, square, nothing)
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


@graded("linear", points=0.5, hidden=True)
def test_layers_of_all_sizes(impl):
    "Any number of rows, inputs and outputs, one of each too."
    rng = np.random.default_rng(4)
    for n, d_in, d_out in ((1, 1, 1), (1, 3, 3), (7, 1, 4), (50, 6, 1), (4, 4, 4)):
        x, weight, bias = rng.normal(size=(n, d_in)), rng.normal(size=(d_out, d_in)), rng.normal(size=d_out)
        assert_matches(impl(x, weight, bias), _layer(x, weight, bias), f"y for {n} rows, {d_in} to {d_out}")


# --- linear_backward(d_y, x, weight)

GRADIENTS = ("d_x", "d_weight", "d_bias")


def _batch():
    """d_y, x and weight for three rows; new arrays each time."""
    d_y = np.array([[1.0, 2.0], [-3.0, 0.5], [4.0, 1.0]])
    return d_y, np.array([[1.0, 2.0, 3.0], [0.0, -1.0, 2.0], [5.0, 1.0, -2.0]]), _weight()


@graded("linear_backward", points=0.5)
def test_gradient_of_the_input_of_a_layer(impl):
    "d_x: each input is used by all outputs, dE/dx_t = sum over s of d_y_s w_{s,t}; each row for itself."
    d_y, x, weight = _batch()
    found = as_parts(impl(d_y, x, weight), GRADIENTS)[0]
    expected = np.array([[_dot(row, column) for column in weight.T] for row in d_y])
    total = np.broadcast_to(weight.sum(axis=0), expected.shape)
    mistakes = {
        "d_y is missing: it does not depend on the gradient that arrives": total,
        "the mean over the batch: each row of x has a gradient of its own": expected / len(d_y),
        "the sum over the batch: each row of x has a gradient of its own": expected.sum(axis=0),
        "transposed: a gradient has the shape of its input, (n, d_in)": expected.T,
        "the sign is flipped": -expected,
        "twice too much: there is no square here": 2 * expected,
        "multiplied by x: y is linear in x, its derivative is the weight alone": expected * x,
    }
    name_mistake(found, expected, mistakes, "d_x")
    assert_matches(found, expected, "d_x")
    x, square = x[:, :2], weight[:, :2]  # square: nothing stops a matrix that is the wrong way round
    found = as_parts(impl(d_y, x, square), GRADIENTS)[0]
    expected = np.array([[_dot(row, column) for column in square.T] for row in d_y])
    wrong = {
        "the weight is the wrong way round (transposed): sum over the outputs s, the rows of the weight": np.array(
            [[_dot(row, one) for one in square] for row in d_y]
        )
    }
    name_mistake(found, expected, wrong, "d_x for a square weight")
    assert_matches(found, expected, "d_x for a square weight")


@graded("linear_backward", points=1)
def test_gradient_of_the_weight_of_a_layer(impl):
    "d_weight: all rows of the batch used the same weight, dE/dw_{s,t} = sum over the rows of d_y_s x_t."
    d_y, x, weight = _batch()
    found = as_parts(impl(d_y, x, weight), GRADIENTS)[1]
    each = np.array([[[float(d * one) for one in inputs] for d in row] for row, inputs in zip(d_y, x, strict=True)])
    expected = each.sum(axis=0)
    mistakes = {
        "transposed: a gradient has the shape of its input, (d_out, d_in)": expected.T,
        "the mean over the batch: a value that is used n times gets the sum": expected / len(d_y),
        "the sum over the batch is missing, there is a matrix for each row": each,
        "the sum over the batch is missing, it is that of the last row alone": each[-1],
        "the sum over the batch is missing, it is that of the first row alone": each[0],
        "d_y is missing: it does not depend on the gradient that arrives": np.broadcast_to(
            x.sum(axis=0), expected.shape
        ),
        "x is missing: dy_s / dw_{s,t} is x_t": np.broadcast_to(d_y.sum(axis=0)[:, np.newaxis], expected.shape),
        "sums of d_y and of x, multiplied: multiply row by row, then sum": np.array(
            [[float(d * one) for one in x.sum(axis=0)] for d in d_y.sum(axis=0)]
        ),
        "the sign is flipped: the step against it comes later": -expected,
        "twice too much: there is no square here": 2 * expected,
        "multiplied by the weight: y is linear in it": expected * weight,
        "that is d_x, or a part of it: the order is d_x, d_weight, d_bias": np.array(
            [[_dot(row, column) for column in weight.T] for row in d_y]
        ),
    }
    name_mistake(found, expected, mistakes, "d_weight")
    assert_matches(found, expected, "d_weight")
    x, square = x[:, :2], weight[:, :2]  # square: nothing stops a matrix that is the wrong way round
    found = as_parts(impl(d_y, x, square), GRADIENTS)[1]
    mistakes = {"transposed: row s belongs to output s": expected[:, :2].T}
    name_mistake(found, expected[:, :2], mistakes, "d_weight, square")
    assert_matches(found, expected[:, :2], "d_weight, square")


@graded("linear_backward", points=0.5)
def test_gradient_of_the_bias_of_a_layer(impl):
    "d_bias: all rows of the batch used the same bias, so it is the sum of d_y over the rows."
    d_y, x, weight = _batch()
    found, expected = as_parts(impl(d_y, x, weight), GRADIENTS)[2], np.array([2.0, 3.5])
    mistakes = {
        "the sum over the batch is missing": d_y,
        "the mean over the batch: a value that is used n times gets the sum": expected / 3,
        "the sum over the outputs: sum over the rows, axis 0": d_y.sum(axis=1),
        "the sum over everything: each output has a bias of its own": d_y.sum(),
        "the sum over the batch is missing, it is that of the last row alone": d_y[-1],
        "the sum over the batch is missing, it is that of the first row alone": d_y[0],
        "d_y is missing: that is how many rows there are": np.full(2, 3.0),
        "d_y is missing: that is the local gradient, 1": np.ones(2),
        "the shape (1, d_out), with an axis too many: the bias is (d_out,)": expected[np.newaxis],
        "the sign is flipped": -expected,
    }
    name_mistake(found, expected, mistakes, "d_bias")
    assert_matches(found, expected, "d_bias")


@graded("linear_backward", points=1, hidden=True)
def test_the_layer_agrees_with_finite_differences(impl):
    "All three gradients for layers of all sizes, one row, one input and one output too, as the forward pass has them."
    rng = np.random.default_rng(6)
    for n, d_in, d_out in ((1, 1, 1), (5, 2, 2), (1, 4, 3), (9, 1, 5), (6, 5, 1)):
        x, weight, bias = rng.normal(size=(n, d_in)), rng.normal(size=(d_out, d_in)), rng.normal(size=d_out)
        d_y = rng.normal(size=(n, d_out))
        expected = (
            central_differences(lambda one, w=weight, b=bias, d=d_y: np.sum(d * _layer(one, w, b)), x),
            central_differences(lambda one, x=x, b=bias, d=d_y: np.sum(d * _layer(x, one, b)), weight),
            central_differences(lambda one, x=x, w=weight, d=d_y: np.sum(d * _layer(x, w, one)), bias),
        )
        for one, right, name in zip(as_parts(impl(d_y, x, weight), GRADIENTS), expected, GRADIENTS, strict=True):
            assert_matches(one, right, f"{name} for {n} rows, {d_in} to {d_out}", rtol=1e-6, atol=1e-7)


# --- sigmoid_backward(d_y, s)


@graded("sigmoid_backward", points=1)
def test_backward_through_a_sigmoid(impl):
    "d_x = d_y s (1 - s), each number for itself; s is the output of the sigmoid."
    s = np.array([[0.5, 0.9], [0.2, 0.75], [0.1, 0.4]])
    d_y = np.array([[4.0, -2.0], [1.0, 3.0], [-5.0, 0.5]])
    slope = np.array([[0.25, 0.09], [0.16, 0.1875], [0.09, 0.24]])
    expected, again = d_y * slope, 1 / (1 + np.exp(-s))
    mistakes = {
        "d_y is missing: that is the local gradient, the chain rule multiplies by what arrives": slope,
        "d_y is added: the chain rule multiplies": d_y + slope,
        "the sigmoid is applied once more: s is already its output": d_y * again * (1 - again),
        "1 - s is missing": d_y * s,
        "s is missing": d_y * (1 - s),
        "the sign is flipped: s (1 - s) is above 0": -expected,
        "1 - s^2 belongs to tanh": d_y * (1 - s**2),
        "s - s^2 is right, s + s^2 is not": d_y * s * (1 + s),
        "the bracket of s (1 - s) is missing": d_y * s - s,
        "the sum over the batch: each row has a gradient of its own": expected.sum(axis=0),
        "the mean over the batch: each number for itself": expected / len(s),
        "d_y (1 - d_y) in place of s (1 - s): what is differentiated is s": d_y * (1 - d_y),
    }
    found = impl(d_y, s)
    name_mistake(found, expected, mistakes, "d_x of the sigmoid")
    assert_matches(found, expected, "d_x of the sigmoid")


@graded("sigmoid_backward", points=0.5, hidden=True)
def test_the_sigmoid_agrees_with_finite_differences(impl):
    "Batches of all sizes, as the forward pass has them; 0 where the sigmoid is saturated."
    rng = np.random.default_rng(8)
    for n, d in ((1, 1), (3, 3), (20, 4)):
        x, d_y = rng.normal(size=(n, d)) * 2, rng.normal(size=(n, d))
        expected = central_differences(lambda one, d_y=d_y: np.sum(d_y / (1 + np.exp(-one))), x)
        assert_matches(impl(d_y, 1 / (1 + np.exp(-x))), expected, f"d_x of {n} rows of {d}", atol=1e-8)
    assert_matches(impl(np.full((1, 2), 7.0), np.array([[0.0, 1.0]])), np.zeros((1, 2)), "d_x at s = 0 and s = 1")


# --- softplus_backward(d_y, x)


@graded("softplus_backward", points=0.5)
def test_backward_through_softplus(impl):
    "d_x = d_y times the derivative of log(1 + e^x), each number for itself."
    x, d_y = np.log([[1.0, 3.0], [1 / 4, 9.0]]), np.array([[4.0, -2.0], [1.0, 5.0]])
    slope = np.array([[1 / 2, 3 / 4], [1 / 5, 9 / 10]])  # e^x / (1 + e^x)
    expected, y = d_y * slope, np.log(1 + np.exp(x))
    mistakes = {
        "d_y is missing: that is the local gradient, the chain rule multiplies by what arrives": slope,
        "that is softplus itself, times d_y: its derivative is needed": d_y * y,
        "1 - s: a sign in the exponent is wrong, softplus gets steeper to the right": d_y * (1 - slope),
        "s (1 - s) is the derivative of the sigmoid; that of softplus is the sigmoid itself": d_y * slope * (1 - slope),
        "the inner derivative e^x is missing": d_y * (1 - slope),
        "the bracket: e^x / 1 + e^x": d_y * 2 * np.exp(x),
        "that is the derivative of relu, 0 or 1: softplus is smooth": d_y * (x > 0),
        "x is taken for the output y: here x is saved": d_y * (1 - np.exp(-x)),
        "the sigmoid of the output: it is that of the input x": d_y / (1 + np.exp(-y)),
        "the derivative of tanh": d_y * (1 - np.tanh(x) ** 2),
        "tanh(x) in place of (1 + tanh(x / 2)) / 2": d_y * np.tanh(x),
        "the sign is flipped": -expected,
        "the mean over the batch: each number for itself": expected / len(x),
    }
    found = impl(d_y, x)
    name_mistake(found, expected, mistakes, "d_x of softplus")
    assert_matches(found, expected, "d_x of softplus")


def _assert_quiet(impl, what):
    assert not impl.warned, (
        f"{what}: the numbers are right, but NumPy warns on the way. Take the exponential of numbers up to 0 only, such as "
        f"-|x|, or use np.tanh, which never overflows."
    )


@graded("softplus_backward", points=1)
def test_softplus_far_from_zero(impl):
    "Every finite x: d_y on the far right, 0 on the far left, no NaN, and no warning."
    x, d_y = np.array([[1000.0, -1000.0], [40.0, -1e300], [1e300, 0.0]]), np.array([[2.0, 3.0], [4.0, 5.0], [6.0, 8.0]])
    expected, what = np.array([[2.0, 0.0], [4.0, 0.0], [6.0, 4.0]]), "d_x of softplus at x up to 1e300"
    found = impl(d_y, x)
    values = as_numbers(found)
    if values is not None and values.shape == x.shape:
        for place in np.ndindex(x.shape):
            assert not np.isnan(values[place]), (
                f"{what}: NaN at x = {x[place]:g}. e^{x[place]:g} is infinite for the computer, and infinity divided by "
                f"infinity is NaN. Divide both by e^x where x is large."
            )
            assert not (x[place] == 1000 and values[place] == 0), (
                f"{what}: 0 at x = 1000, but softplus has the slope 1 there. Something overflowed and was set to 0."
            )
    assert_matches(found, expected, what)
    _assert_quiet(impl, what)


@graded("softplus_backward", points=0.5, hidden=True)
def test_softplus_agrees_with_finite_differences(impl):
    "Batches of all sizes, as the forward pass has them, and symmetric: the slopes at x and -x add up to 1."
    rng = np.random.default_rng(9)
    for n, d in ((1, 1), (4, 2), (30, 3)):
        x, d_y = 3 * rng.normal(size=(n, d)), rng.normal(size=(n, d))
        expected = central_differences(lambda one, d_y=d_y: np.sum(d_y * np.logaddexp(0, one)), x)
        assert_matches(impl(d_y, x), expected, f"d_x of {n} rows of {d}", atol=1e-8)
    x = np.geomspace(1e-3, 1e5, 60)[np.newaxis]
    both = np.asarray(impl(np.ones_like(x), x)) + np.asarray(impl(np.ones_like(x), -x))
    assert_matches(both, np.ones_like(x), "slope at x + slope at -x")


# --- relative_error_gradient(filtered, reference, spp, epsilon)


@graded("relative_error_gradient", points=1)
def test_gradient_of_the_relative_error(impl):
    "dE_i / dc_hat_{i,q} = ??? for four pixels of three channels."
    filtered = np.array([[0.5, 0.3, 0.2], [1.5, 0.1, 2.0], [0.2, 0.6, 0.9], [0.7, 0.1, 0.4]])
    reference = np.array([[0.4, 0.3, 0.5], [1.0, 0.2, 2.5], [0.1, 0.8, 0.9], [0.5, 0.2, 0.3]])
    spp, epsilon = 9, 0.05
    difference, below = filtered - reference, reference**2 + epsilon
    expected = spp * difference / below
    mistakes = {
        "n / 2 in front: the 2 of the derivative cancels it": expected / 2,
        "2 n in front: the 1/2 in front of the sum cancels the 2": 2 * expected,
        "n is missing": expected / spp,
        "n and 1/2 are missing": 2 * expected / spp,
        "divided by n: n stands in front": expected / spp**2,
        "the sign is flipped: c_hat - c, too bright is positive": -expected,
        "that is E itself, not its derivative: the square goes": spp / 2 * difference**2 / below,
        "the square goes when it is differentiated": spp * difference**2 / below,
        "the sign of the difference is lost": np.abs(expected),
        "c_hat^2 + epsilon below the line: it is the reference that stands there": spp
        * difference
        / (filtered**2 + epsilon),
        "c + epsilon below the line: c is squared": spp * difference / (reference + epsilon),
        "epsilon is missing": spp * difference / reference**2,
        "(c + epsilon)^2 below the line: epsilon is added to the square": spp * difference / (reference + epsilon) ** 2,
        "what stands below the line is squared: it does not depend on c_hat, no quotient rule is needed": spp
        * difference
        / below**2,
        "nothing stands below the line: the error is relative": spp * difference,
        "the mean over the channels": expected / 3,
        "the mean over the pixels: E_i is that of one pixel": expected / 4,
        "the sum over the channels: each channel of c_hat has a derivative of its own": expected.sum(axis=1),
        "the sum over the pixels: each has a derivative of its own": expected.sum(axis=0),
        "the sum of everything is one number; each entry of c_hat has a derivative": expected.sum(),
        "the root of what stands below the line": spp * difference / np.sqrt(below),
    }
    found = impl(filtered, reference, spp, epsilon)
    name_mistake(found, expected, mistakes, "dE/dc_hat")
    assert_matches(found, expected, "dE/dc_hat")


@graded("relative_error_gradient", points=0.5)
def test_relative_error_of_a_black_reference(impl):
    "Where the reference is black epsilon alone stands below the line; where the filter is right the gradient is 0."
    filtered, reference = np.array([[0.02, 0.0, 0.7]]), np.array([[0.0, 0.0, 0.7]])
    for epsilon in (0.01, 1e-4):
        found, expected = impl(filtered, reference, 4, epsilon), np.array([[4 * 0.02 / epsilon, 0.0, 0.0]])
        values = as_numbers(found)
        assert values is None or np.isfinite(values).all(), (
            f"not finite where the reference is black: is epsilon ({epsilon:g}) added to c^2?"
        )
        what = f"dE/dc_hat, epsilon {epsilon:g}, a black reference"
        name_mistake(
            found, expected, {"epsilon is another constant than the argument": expected * epsilon / 0.01}, what
        )
        assert_matches(found, expected, what)


@graded("relative_error_gradient", points=0.5, hidden=True)
def test_the_relative_error_agrees_with_finite_differences(impl):
    "Any number of pixels and samples, one number of samples for all or one a pixel, as E itself has it."
    rng = np.random.default_rng(2)
    for n, spp in ((1, 1), (4, 16), (5, rng.integers(1, 64, (5, 1)))):
        filtered, reference = rng.gamma(1.0, 0.5, (n, 3)), rng.gamma(1.0, 0.5, (n, 3))
        epsilon = float(rng.uniform(0.001, 0.1))

        def error(one, reference=reference, spp=spp, epsilon=epsilon):
            return np.sum(spp / 2 * (one - reference) ** 2 / (reference**2 + epsilon))

        found = impl(filtered, reference, spp, epsilon)
        assert_matches(found, central_differences(error, filtered), f"dE/dc_hat of {n} pixels", rtol=1e-6, atol=1e-6)


# --- five_faults


@graded("five_faults", points=1.5)
def test_the_five_faults_are_found(impl):
    "What is wrong with each of the five backward passes."
    given = ("A", "A", "A", "A", "A")
    letters = [str(one).strip().upper() for one in impl] if isinstance(impl, (tuple, list, str)) else []
    assert len(letters) == 5, f"5 letters are needed, as in {given}."
    hints = (
        ("decay", "E", "the check received the right numbers but for one thing. What is the derivative of e^-x?"),
        ("cube", "F", "call it twice: is x still what it was after the first call?"),
        (
            "product",
            "A",
            "what does the check say of rows and columns? dE/dw_{s,t} stands in row s.",
        ),
        ("energy", "D", "received and expected have a constant ratio. What is the derivative of x^2?"),
        ("shifted", "B", "which shape was received, and which has the bias? How many rows use it?"),
    )
    for letter, (name, right, hint) in zip(letters, hints, strict=True):
        assert letter in tuple("ABCDEFG"), f"{name}: {letter!r} is none of the letters A to G."
        assert letter == right, f"{name} is not {letter}: {hint}"


# --- at_a_kink(weight, bias)


def _assert_kink(impl, weight, bias, what):
    """Finite differences of relu(x W^T + b), summed over the neurons, differ from the backward pass at x."""
    x = as_numbers(found := impl(weight, bias))
    d_in = weight.shape[1]
    if x is None or x.shape != (d_in,):
        assert_matches(found, np.zeros(d_in), f"{what}: the row x")
    assert np.isfinite(x).all(), f"{what}: the row must be finite."
    inside = x @ weight.T + bias
    right = (inside > 0) @ weight
    measured = central_differences(lambda one: np.sum(np.maximum(one @ weight.T + bias, 0)), x, step=6e-6)
    off = np.linalg.norm(measured - right) / max(np.linalg.norm(measured), np.linalg.norm(right), 1e-300)
    if off > 1e-3:
        return
    flipped = np.abs(x @ weight.T - bias).min()
    nearest = int(np.argmin(np.abs(inside)))
    why = (
        "There w_s x - b_s is 0: is a sign of the bias flipped?"
        if flipped < 1e-6
        else f"The neuron nearest to its kink is {nearest}, and there w_s x + b_s is {inside[nearest]:.3g}: it must be 0."
    )
    raise Finding(f"{what}: at x = {_short(x)} finite differences and the backward pass agree. {why}")


@graded("at_a_kink", points=1)
def test_a_right_backward_pass_looks_wrong(impl):
    "At the row that you give, finite differences of the network disagree with its backward pass, which is right."
    weight, bias = np.array([[1.0, 2.0], [-1.5, 1.0], [2.0, 0.5]]), np.array([0.5, 2.0, -1.0])
    _assert_kink(impl, weight, bias, "three neurons of two inputs")


@graded("at_a_kink", points=0.5, hidden=True)
def test_kinks_of_other_networks(impl):
    "Any weights: one neuron, one input, many of both, and biases of 0."
    rng = np.random.default_rng(12)
    for d, d_in in ((1, 1), (1, 3), (8, 1), (10, 5)):
        weight, bias = rng.normal(size=(d, d_in)), rng.normal(size=d)
        _assert_kink(impl, weight, bias, f"{d} neurons of {d_in} inputs")
    _assert_kink(impl, rng.normal(size=(3, 2)), np.zeros(3), "biases of 0")


# --- rprop_step(parameter, gradient, sign, step, grow, shrink, smallest, largest)

RPROP = ("the parameter", "the sign", "the step")


def _assert_step(impl, given, expected, mistakes, case):
    """The three results, with the mistakes of each by name: (which, words) -> value."""
    found = as_parts(impl(*given), RPROP)
    for which in (2, 1, 0):  # a wrong step makes a wrong parameter
        named = {words: value for (place, words), value in mistakes.items() if place == which}
        name_mistake(found[which], expected[which], named, f"{case}: {RPROP[which]}")
        assert_matches(found[which], expected[which], f"{case}: {RPROP[which]}")


@graded("rprop_step", points=0.5)
def test_rprop_goes_on_where_signs_agree(impl):
    "The sign is that of the step before: the step grows, and the parameter goes one step against it."
    parameter, gradient = np.array([1.0, 1.0, -2.0]), np.array([7.0, -0.01, 100.0])
    sign, step = np.array([1.0, -1.0, 1.0]), np.array([0.1, 0.2, 0.4])
    grown = np.array([0.15, 0.3, 0.6])
    expected = (np.array([0.85, 1.3, -2.6]), sign, grown)
    mistakes = {
        (2, "that is the sign: the order is parameter, sign, step"): sign,
        (2, "it does not grow"): step,
        (2, "it shrinks where the signs agree: grow and shrink are exchanged"): step / 4,
        (2, "grow is added: it is a factor"): step + 1.5,
        (2, "multiplied by the gradient: only its sign counts"): grown * np.abs(gradient),
        (1, "the gradient itself is remembered: its sign is needed"): gradient,
        (1, "flipped: the sign of the gradient, not that of the move"): -sign,
        (1, "the product of both signs: that of the gradient is remembered"): np.ones(3),
        (0, "it climbs: a step against the sign of the gradient"): parameter + sign * grown,
        (0, "the step before is taken, not the new one"): parameter - sign * step,
        (0, "multiplied by the gradient: only its sign counts"): parameter - gradient * grown,
        (0, "the sign is squared, or lost: all go the same way"): parameter - grown,
        (0, "it does not move"): parameter,
    }
    given = (parameter, gradient, sign, step, 1.5, 0.25, 1e-6, 50.0)
    _assert_step(impl, given, expected, mistakes, "signs agree")


@graded("rprop_step", points=0.5)
def test_rprop_waits_where_the_sign_has_flipped(impl):
    "The sign has flipped: the step shrinks, the parameter stays where it is, and 0 is remembered as its sign."
    parameter, gradient = np.array([1.0, -3.0]), np.array([-2.0, 0.5])
    sign, step = np.array([1.0, -1.0]), np.array([0.8, 0.4])
    shrunk, now = np.array([0.2, 0.1]), np.array([-1.0, 1.0])
    expected = (parameter, np.zeros(2), shrunk)
    mistakes = {
        (2, "it stays as it was: it shrinks where the sign has flipped"): step,
        (2, "it grows where the sign has flipped: grow and shrink are exchanged"): step * 1.5,
        (2, "shrink is subtracted: it is a factor"): step - 0.25,
        (2, "divided by shrink: it is a factor below 1"): step / 0.25,
        (1, "the new sign is remembered: it must be 0, or the next step shrinks once more"): now,
        (1, "the old sign is kept: 0 is remembered"): sign,
        (0, "it moves: where the sign has flipped the parameter waits for one step"): parameter - now * shrunk,
        (0, "it goes back to where it was: this variant waits for one step"): parameter - now * step,
        (0, "it goes on by the old sign: where the sign has flipped it waits"): parameter - sign * shrunk,
    }
    given = (parameter, gradient, sign, step, 1.5, 0.25, 1e-6, 50.0)
    _assert_step(impl, given, expected, mistakes, "signs flipped")


@graded("rprop_step", points=0.5)
def test_rprop_at_zero_and_at_its_bounds(impl):
    "One of the signs is 0: the step stays. A step never leaves its bounds, and the parameter moves by the bounded one."
    parameter, step = np.array([1.0, 1.0, 1.0]), np.array([0.1, 0.1, 0.1])
    gradient, sign = np.array([3.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    mistakes = {
        (2, "it grows where one sign is 0: there it stays"): step * 1.5,
        (2, "it shrinks where one sign is 0: there it stays"): step / 4,
        (0, "it must move where the remembered sign is 0: there nothing is compared"): parameter,
    }
    expected = (np.array([0.9, 1.0, 1.0]), np.array([1.0, 0.0, 0.0]), step)
    _assert_step(impl, (parameter, gradient, sign, step, 1.5, 0.25, 1e-6, 50.0), expected, mistakes, "a sign of 0")
    parameter, step = np.array([1.0, 1.0]), np.array([4.0, 0.3])
    gradient, sign, free = np.array([3.0, -3.0]), np.array([1.0, 1.0]), np.array([6.0, 0.075])
    mistakes = {
        (2, "the bounds are missing"): free,
        (2, "the largest step is not held"): np.array([6.0, 0.2]),
        (2, "the smallest step is not held"): np.array([5.0, 0.075]),
        (2, "bounded before it is multiplied: first multiply, then bound"): np.array([6.0, 0.075]),
        (0, "it moves by the step before it was bounded"): parameter - np.array([6.0, 0.0]),
    }
    expected = (np.array([-4.0, 1.0]), np.array([1.0, 0.0]), np.array([5.0, 0.2]))
    _assert_step(
        impl, (parameter, gradient, sign, step, 1.5, 0.25, 0.2, 5.0), expected, mistakes, "bounds of 0.2 and 5"
    )


@graded("rprop_step", points=0.5, hidden=True)
def test_rprop_over_several_steps(impl):
    "Twenty steps of a weight and of a matrix of them, each number by itself, in any mixture of cases."
    rng = np.random.default_rng(14)
    for shape in ((1,), (4, 3)):
        parameter, sign, step = rng.normal(size=shape), np.zeros(shape), np.full(shape, 0.1)
        numbers = [[float(a), 0.0, 0.1] for a in parameter.ravel()]
        for turn in range(20):
            gradient = np.round(parameter - 0.3, 1) * rng.choice([1.0, 1.0, 0.0, -1.0], shape)
            parameter, sign, step = as_parts(impl(parameter, gradient, sign, step, 1.3, 0.4, 0.01, 0.5), RPROP)
            for one, slope in zip(numbers, gradient.ravel().tolist(), strict=True):
                _walk_one(one, slope)
            for found, place in ((step, 2), (sign, 1), (parameter, 0)):
                right = np.array([one[place] for one in numbers]).reshape(shape)
                assert_matches(found, right, f"step {turn + 1}: {RPROP[place]}", atol=1e-9)


def _walk_one(one, slope):
    """One step of one number [parameter, sign, step], case by case."""
    now = (slope > 0) - (slope < 0)
    if now * one[1] > 0:
        one[2] *= 1.3
    elif now * one[1] < 0:
        one[2] *= 0.4
        now = 0
    one[2] = min(max(one[2], 0.01), 0.5)
    one[1] = float(now)
    one[0] -= now * one[2]


# --- smallest_model(parameters, errors)


def _index(found, what):
    """The answer as a whole number."""
    if found is None or isinstance(found, str) or np.shape(found) != ():
        assert_matches(found, 0, what)
    value = float(found)
    if not value.is_integer():
        raise Finding(f"{what}: a whole number is needed, the index of the model, yours is {value:g}.")
    return int(value)


def _assert_chosen(found, expected, mistakes, what):
    chosen = _index(found, what)
    for words, value in mistakes.items():
        assert chosen != value or value == expected, f"{what}: yours is {chosen}, expected {expected}: {words}."
    assert chosen == expected, f"{what}: yours is {chosen}, expected {expected}."


@graded("smallest_model", points=1)
def test_the_smallest_of_the_models_that_are_good_enough(impl):
    "The fewest parameters among the models whose mean is at most that of the best plus its standard error."
    parameters = np.array([61, 40, 13, 8, 31, 9, 22])
    means = np.array([2.0, 4.5, 2.5, 4.0, 2.2, 3.05, 2.55])
    spread = 1.6 * np.sqrt(3 / 4) * np.array([-1.0, -1.0, 1.0, 1.0])  # standard deviation 1.6, standard error 0.8
    errors = means[:, np.newaxis] + np.where(np.arange(7) == 0, 1.0, 1e-3)[:, np.newaxis] * spread
    found = impl(parameters, errors)
    assert found is None or np.shape(found) != () or found not in parameters.tolist(), (
        f"that is how many parameters a model has ({found}): its index is asked for."
    )
    mistakes = {
        "that is the best mean; a smaller model is as good for all we know": 0,
        "is that an index among those that are good enough? Of all models it is another": 1,
        "that is the model with the fewest parameters, but its error is too large": 3,
        "its error is small enough, but there is one with fewer parameters": 4,
        "too generous: the standard error is the standard deviation divided by sqrt(folds)": 5,
        "good enough, but there are some with fewer parameters; take the smallest of all": 6,
    }
    _assert_chosen(found, 2, mistakes, "seven models, four folds")


@graded("smallest_model", points=0.5)
def test_whose_standard_error_counts(impl):
    "The standard error is that of the best model, over its folds, with folds - 1 below the line."
    parameters = np.array([30, 20, 10, 5])
    folds = np.array([-1.0, 0.0, 1.0])  # standard deviation 1, standard error 0.577; dividing by 3: 0.471
    errors = np.array([1.0, 1.5, 1.55, 2.2])[:, np.newaxis] + np.array([1.0, 1.0, 1.0, 3.0])[:, np.newaxis] * folds
    mistakes = {
        "is the standard deviation divided by folds in place of folds - 1 (ddof=1), or is none allowed for?": 0,
        "that model's own standard error was counted: it is that of the best": 3,
        "there is one with fewer parameters that is good enough": 1,
    }
    _assert_chosen(impl(parameters, errors), 2, mistakes, "four models, three folds")
    errors = np.array([[0.9, 1.1], [0.95, 1.26]])  # best 1.0, standard error 0.1; the other 1.105
    mistakes = {"its mean is above the bound: is the standard deviation divided by sqrt(folds)?": 1}
    _assert_chosen(impl(np.array([9, 3]), errors), 0, mistakes, "two models, two folds")


@graded("smallest_model", points=0.5, hidden=True)
def test_the_smallest_of_any_models(impl):
    "Any number of models and folds, in any order; one model, and models without any spread."
    rng = np.random.default_rng(15)
    for m, folds in ((1, 2), (2, 5), (8, 5), (30, 10)):
        for _ in range(6):
            parameters = rng.permutation(np.arange(3, 3 + 4 * m, 4))
            errors = rng.gamma(4.0, 0.1, (m, folds)) + rng.uniform(0, 0.3, (m, 1))
            mean = [sum(row) / folds for row in errors.tolist()]
            best = min(range(m), key=mean.__getitem__)
            deviation = (sum((one - mean[best]) ** 2 for one in errors[best].tolist()) / (folds - 1)) ** 0.5
            good = [k for k in range(m) if mean[k] <= mean[best] + deviation / folds**0.5]
            expected = min(good, key=parameters.__getitem__)
            _assert_chosen(impl(parameters, errors), expected, {}, f"{m} models, {folds} folds")
    exact = np.array([[0.5, 0.5], [0.25, 0.25], [0.25, 0.25]])
    _assert_chosen(impl(np.array([1, 8, 5]), exact), 2, {}, "errors without any spread")
