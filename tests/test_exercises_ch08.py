"""The exercises of chapter 08 tested themselves: the reference earns every point, each typical mistake is named."""

import numpy as np
import pytest

import mcdenoise as mcd
from answers import EXERCISES, ROOT, assert_earns_every_point, assert_mistake_is_named, reference
from mcdenoise.classroom.checking.pytest_plugin import load_answer
from mcdenoise.nn.scalar import backward
from mcdenoise.study.capacity import smallest_model

pytestmark = pytest.mark.ch08


# --- layers


def layer(x, weight, bias):
    return x @ weight.T + bias


def spoiling_layer(x, weight, bias):
    bias *= 1.5
    return x @ weight.T + bias


def layer_with_a_bias_for_rows(x, weight, bias):
    return x @ weight.T + bias[: len(x), np.newaxis] if len(x) <= len(bias) else layer(x, weight, bias)


def layer_by_shape(x, weight, bias):
    """The weight whichever way round fits, its own way first."""
    return (x @ weight if weight.shape[0] == x.shape[1] else x @ weight.T) + bias


def backward_pass(d_x=None, d_weight=None, d_bias=None):
    """The backward pass of a layer with one part replaced; a part is a function of (d_y, x, weight)."""

    def function(d_y, x, weight):
        parts = (lambda d, x, w: d @ w, lambda d, x, w: d.T @ x, lambda d, x, w: d.sum(axis=0))
        chosen = (given or part for given, part in zip((d_x, d_weight, d_bias), parts, strict=True))
        return tuple(part(d_y, x, weight) for part in chosen)

    return function


linear_right = backward_pass()


def square_transposed(d_y, x, weight):
    return d_y @ (weight.T if weight.shape[0] == weight.shape[1] else weight)


def weight_square_transposed(d_y, x, weight):
    found = d_y.T @ x
    return found.T if found.shape[0] == found.shape[1] else found


def spoiling_backward(d_y, x, weight):
    d_y /= len(d_y)
    return linear_right(d_y, x, weight)


# --- activations


def stable(x):
    small = np.exp(-np.abs(x))
    return np.where(x >= 0, 1.0, small) / (1 + small)


def plain(x):
    return 1 / (1 + np.exp(-x))


def spoiling_sigmoid(d_y, s):
    s *= 1 - s
    return d_y * s


def with_jacobian(d_y, s):
    return d_y @ np.diag((s * (1 - s)).ravel())


def set_to_zero(d_y, x):
    with np.errstate(all="ignore"):
        return d_y * np.nan_to_num(np.exp(x) / (1 + np.exp(x)))


def clipped(d_y, x):
    return d_y * plain(np.clip(x, -1, 1))


def both_branches(d_y, x):
    return d_y * np.where(x > 0, 1 / (1 + np.exp(-x)), np.exp(x) / (1 + np.exp(x)))


# --- the relative error


def relative(formula):
    """An answer from (difference, reference, filtered, spp, epsilon)."""
    return lambda filtered, reference, spp, epsilon: formula(filtered - reference, reference, filtered, spp, epsilon)


relative_right = relative(lambda d, c, f, n, e: n * d / (c**2 + e))


# --- RPROP


def rprop(
    parameter,
    gradient,
    sign,
    step,
    grow,
    shrink,
    smallest,
    largest,
    *,
    factor=None,
    bounded=np.clip,
    remembered=None,
    moved=None,
):
    """One step, each part open to a mistake."""
    now = np.sign(gradient)
    agree = now * sign
    factors = factor(agree, grow, shrink) if factor else np.where(agree > 0, grow, np.where(agree < 0, shrink, 1.0))
    new = bounded(step * factors, smallest, largest)
    keep = remembered(now, agree, gradient, sign) if remembered else np.where(agree < 0, 0.0, now)
    used = np.where(agree < 0, 0.0, now)
    return (moved(parameter, used, now, new, step, gradient, sign) if moved else parameter - used * new), keep, new


def rprop_with(**parts):
    return lambda *given: rprop(*given, **parts)


# --- the smallest model


def choose(parameters, errors, *, ddof=1, root=True, own=False, pick=None):
    """The rule, with places for mistakes."""
    mean, folds = errors.mean(axis=1), errors.shape[1]
    error = errors.std(axis=1, ddof=ddof) / (np.sqrt(folds) if root else 1)
    bound = mean.min() + (error if own else error[mean.argmin()])
    good = np.flatnonzero(mean <= bound)
    return pick(good, mean, parameters) if pick else int(good[np.argmin(parameters[good])])


def choose_with(**parts):
    return lambda *given: choose(*given, **parts)


# --- a kink


def on_the_boundary(weight, bias):
    return -bias[-1] * weight[-1] / (weight[-1] @ weight[-1])


def along_one_axis(weight, bias):
    """Another right idea: only one coordinate is not 0."""
    axis = int(np.argmax(np.abs(weight[0])))
    return np.eye(weight.shape[1])[axis] * -bias[0] / weight[0, axis]


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("used_twice", "the example", (-4, -4, 3), "the example"),
    ("used_twice", "one way, by q", (8, 8, -6), "x goes into p = x z as well"),
    ("used_twice", "one way, by p", (-12, 8, -6), "x goes into q = x + y as well"),
    ("used_twice", "multiplied", (-96, 8, -6), "added, not multiplied"),
    ("used_twice", "subtracted", (20, 8, -6), "mind the sign of z"),
    ("used_twice", "local alone", (-3, 1, -2), "local gradients alone"),
    ("used_twice", "dy local", (-4, 1, -6), "multiply it by what arrives at q"),
    ("used_twice", "own value", (-4, 3, -6), "the other factor, p"),
    ("used_twice", "dz local", (-4, 8, -2), "multiply it by what arrives at p"),
    ("used_twice", "dz own value", (-4, 8, -16), "the other factor, q"),
    ("used_twice", "x forgotten", (-4, 8, 3), "dp/dz is x"),
    ("used_twice", "signs", (4, -8, 6), "all signs are flipped"),
    ("used_twice", "a guess", (-4, 8, 5), "into a table"),
    ("used_twice", "one number", -4, "three numbers are needed"),
    ("used_twice", "words", "abc", "three numbers are needed"),
    ("linear", "bias forgotten", lambda x, w, b: x @ w.T, "the bias is missing"),
    ("linear", "bias subtracted", lambda x, w, b: x @ w.T - b, "the bias is subtracted"),
    ("linear", "bias for rows", layer_with_a_bias_for_rows, "added to rows in place of columns"),
    ("linear", "sum of biases", lambda x, w, b: x @ w.T + b.sum(), "all biases are added"),
    ("linear", "transposed result", lambda x, w, b: layer(x, w, b).T, "transposed: a row for each row of x"),
    ("linear", "not transposed", lambda x, w, b: x @ w + b, "stopped with ValueError"),
    ("linear", "whichever fits", layer_by_shape, "the weight is not transposed"),
    ("linear", "one row", lambda x, w, b: layer(x, w, b)[0], "only the first row"),
    ("linear", "summed", lambda x, w, b: layer(x, w, b).sum(axis=0), "an answer of its own"),
    ("linear", "bias times", lambda x, w, b: x @ w.T * b, "the bias is multiplied"),
    ("linear", "spoils its input", spoiling_layer, "modified its input `bias`"),
    ("linear", "returns nothing", lambda x, w, b: None, "is the `return` missing"),
    ("linear_backward", "d_x transposed weight", backward_pass(square_transposed), "the wrong way round"),
    ("linear_backward", "weight.T", backward_pass(lambda d, x, w: d @ w.T), "stopped with ValueError"),
    (
        "linear_backward",
        "d_x without d_y",
        backward_pass(lambda d, x, w: np.ones_like(d) @ w),
        "d_x: d_y is missing",
    ),
    ("linear_backward", "d_x mean", backward_pass(lambda d, x, w: d @ w / len(d)), "has a gradient of its own"),
    (
        "linear_backward",
        "d_x sum",
        backward_pass(lambda d, x, w: (d @ w).sum(axis=0)),
        "each row of x has a gradient of its own",
    ),
    ("linear_backward", "d_x sign", backward_pass(lambda d, x, w: -d @ w), "d_x: the sign is flipped"),
    ("linear_backward", "d_x times x", backward_pass(lambda d, x, w: d @ w * x), "the weight alone"),
    ("linear_backward", "d_x twice", backward_pass(lambda d, x, w: 2 * d @ w), "there is no square here"),
    (
        "linear_backward",
        "d_weight transposed",
        backward_pass(d_weight=lambda d, x, w: x.T @ d),
        "d_weight: transposed",
    ),
    (
        "linear_backward",
        "d_weight transposed where it fits",
        backward_pass(d_weight=weight_square_transposed),
        "row s belongs to output s",
    ),
    (
        "linear_backward",
        "d_weight mean",
        backward_pass(d_weight=lambda d, x, w: d.T @ x / len(x)),
        "d_weight: the mean over the batch",
    ),
    (
        "linear_backward",
        "d_weight a matrix a row",
        backward_pass(d_weight=lambda d, x, w: d[:, :, np.newaxis] * x[:, np.newaxis]),
        "a matrix for each row",
    ),
    (
        "linear_backward",
        "d_weight overwritten in a loop",
        backward_pass(d_weight=lambda d, x, w: np.outer(d[-1], x[-1])),
        "that of the last row alone",
    ),
    (
        "linear_backward",
        "d_weight of the first row",
        backward_pass(d_weight=lambda d, x, w: np.outer(d[0], x[0])),
        "that of the first row alone",
    ),
    (
        "linear_backward",
        "d_weight without d_y",
        backward_pass(d_weight=lambda d, x, w: np.ones_like(d).T @ x),
        "d_weight: d_y is missing",
    ),
    (
        "linear_backward",
        "d_weight without x",
        backward_pass(d_weight=lambda d, x, w: d.T @ np.ones_like(x)),
        "x is missing",
    ),
    (
        "linear_backward",
        "product of sums",
        backward_pass(d_weight=lambda d, x, w: np.outer(d.sum(axis=0), x.sum(axis=0))),
        "multiply row by row, then sum",
    ),
    ("linear_backward", "d_weight sign", backward_pass(d_weight=lambda d, x, w: -d.T @ x), "comes later"),
    ("linear_backward", "d_weight times it", backward_pass(d_weight=lambda d, x, w: d.T @ x * w), "linear in it"),
    ("linear_backward", "d_bias per row", backward_pass(d_bias=lambda d, x, w: d), "d_bias: the sum over the batch"),
    ("linear_backward", "d_bias mean", backward_pass(d_bias=lambda d, x, w: d.mean(axis=0)), "d_bias: the mean"),
    (
        "linear_backward",
        "d_bias axis",
        backward_pass(d_bias=lambda d, x, w: d.sum(axis=1)),
        "sum over the rows, axis 0",
    ),
    ("linear_backward", "d_bias one number", backward_pass(d_bias=lambda d, x, w: d.sum()), "a bias of its own"),
    (
        "linear_backward",
        "d_bias last row",
        backward_pass(d_bias=lambda d, x, w: d[-1]),
        "d_bias: the sum over the batch",
    ),
    (
        "linear_backward",
        "d_bias ones",
        backward_pass(d_bias=lambda d, x, w: np.ones(d.shape[1])),
        "the local gradient, 1",
    ),
    (
        "linear_backward",
        "d_bias counted",
        backward_pass(d_bias=lambda d, x, w: np.full(d.shape[1], float(len(d)))),
        "how many rows there are",
    ),
    (
        "linear_backward",
        "d_bias keepdims",
        backward_pass(d_bias=lambda d, x, w: d.sum(axis=0, keepdims=True)),
        "an axis too many",
    ),
    ("linear_backward", "order", lambda d, x, w: (d.T @ x, d @ w, d.sum(axis=0)), "the order is"),
    ("linear_backward", "two results", lambda d, x, w: linear_right(d, x, w)[:2], "3 things are needed"),
    ("linear_backward", "spoils its input", spoiling_backward, "modified its input `d_y`"),
    ("linear_backward", "returns nothing", lambda d, x, w: None, "is the `return` missing"),
    ("sigmoid_backward", "d_y missing", lambda d, s: s * (1 - s), "d_y is missing"),
    ("sigmoid_backward", "d_y added", lambda d, s: d + s * (1 - s), "the chain rule multiplies"),
    ("sigmoid_backward", "once more", lambda d, s: d * plain(s) * (1 - plain(s)), "already its output"),
    ("sigmoid_backward", "1 - s missing", lambda d, s: d * s, "1 - s is missing"),
    ("sigmoid_backward", "s missing", lambda d, s: d * (1 - s), "s is missing"),
    ("sigmoid_backward", "sign", lambda d, s: d * s * (s - 1), "s (1 - s) is above 0"),
    ("sigmoid_backward", "tanh", lambda d, s: d * (1 - s * s), "belongs to tanh"),
    ("sigmoid_backward", "plus", lambda d, s: d * s * (1 + s), "s + s^2 is not"),
    ("sigmoid_backward", "bracket", lambda d, s: d * s - s, "the bracket"),
    ("sigmoid_backward", "summed", lambda d, s: (d * s * (1 - s)).sum(axis=0), "the sum over the batch"),
    ("sigmoid_backward", "mean", lambda d, s: d * s * (1 - s) / len(s), "the mean over the batch"),
    ("sigmoid_backward", "of d_y", lambda d, s: d * (1 - d), "what is differentiated is s"),
    ("sigmoid_backward", "a Jacobian", with_jacobian, "stopped with ValueError"),
    ("sigmoid_backward", "overwrites s", spoiling_sigmoid, "modified its input `s`"),
    ("softplus_backward", "d_y missing", lambda d, x: stable(x), "d_y is missing"),
    ("softplus_backward", "forward", lambda d, x: d * np.logaddexp(0, x), "softplus itself"),
    ("softplus_backward", "sign inside", lambda d, x: d * stable(-x), "a sign in the exponent"),
    ("softplus_backward", "s (1 - s)", lambda d, x: d * stable(x) * stable(-x), "the sigmoid itself"),
    ("softplus_backward", "relu", lambda d, x: d * (x > 0), "softplus is smooth"),
    ("softplus_backward", "x for y", lambda d, x: d * (1 - np.exp(-x)), "taken for the output y"),
    ("softplus_backward", "of the output", lambda d, x: d * stable(np.logaddexp(0, x)), "it is that of the input"),
    ("softplus_backward", "tanh", lambda d, x: d * np.tanh(x), "(1 + tanh(x / 2)) / 2"),
    ("softplus_backward", "bracket", lambda d, x: d * np.exp(x) / 1 + d * np.exp(x), "the bracket"),
    ("softplus_backward", "sign", lambda d, x: -d * stable(x), "the sign is flipped"),
    ("softplus_backward", "mean", lambda d, x: d * stable(x) / len(x), "the mean over the batch"),
    ("softplus_backward", "infinity by infinity", lambda d, x: d * np.exp(x) / (1 + np.exp(x)), "NaN at x = 1000"),
    ("softplus_backward", "NaN set to 0", set_to_zero, "Something overflowed"),
    ("softplus_backward", "clipped", clipped, "softplus"),
    ("softplus_backward", "warns", lambda d, x: d * plain(x), "NumPy warns on the way"),
    ("softplus_backward", "warns in a branch not taken", both_branches, "NumPy warned: overflow"),
    ("relative_error_gradient", "n/2", relative(lambda d, c, f, n, e: n / 2 * d / (c**2 + e)), "n / 2 in front"),
    ("relative_error_gradient", "2n", relative(lambda d, c, f, n, e: 2 * n * d / (c**2 + e)), "2 n in front"),
    ("relative_error_gradient", "no n", relative(lambda d, c, f, n, e: d / (c**2 + e)), "n is missing"),
    ("relative_error_gradient", "by n", relative(lambda d, c, f, n, e: d / (c**2 + e) / n), "n stands in front"),
    ("relative_error_gradient", "sign", relative(lambda d, c, f, n, e: -n * d / (c**2 + e)), "the sign is flipped"),
    ("relative_error_gradient", "E", relative(lambda d, c, f, n, e: n / 2 * d**2 / (c**2 + e)), "E itself"),
    ("relative_error_gradient", "square", relative(lambda d, c, f, n, e: n * d**2 / (c**2 + e)), "the square goes"),
    ("relative_error_gradient", "absolute", relative(lambda d, c, f, n, e: n * np.abs(d) / (c**2 + e)), "is lost"),
    ("relative_error_gradient", "c_hat", relative(lambda d, c, f, n, e: n * d / (f**2 + e)), "it is the reference"),
    ("relative_error_gradient", "c", relative(lambda d, c, f, n, e: n * d / (c + e)), "c is squared"),
    ("relative_error_gradient", "(c + e)^2", relative(lambda d, c, f, n, e: n * d / (c + e) ** 2), "to the square"),
    ("relative_error_gradient", "no epsilon", relative(lambda d, c, f, n, e: n * d / c**2), "epsilon is missing"),
    (
        "relative_error_gradient",
        "quotient rule",
        relative(lambda d, c, f, n, e: n * d / (c**2 + e) ** 2),
        "no quotient rule",
    ),
    ("relative_error_gradient", "absolute error", relative(lambda d, c, f, n, e: n * d), "the error is relative"),
    (
        "relative_error_gradient",
        "channels",
        relative(lambda d, c, f, n, e: n * d / (c**2 + e) / 3),
        "over the channels",
    ),
    (
        "relative_error_gradient",
        "pixels",
        relative(lambda d, c, f, n, e: n * d / (c**2 + e) / len(c)),
        "E_i is that of one pixel",
    ),
    (
        "relative_error_gradient",
        "sum of channels",
        relative(lambda d, c, f, n, e: (n * d / (c**2 + e)).sum(axis=1)),
        "a derivative of its own",
    ),
    (
        "relative_error_gradient",
        "one number",
        relative(lambda d, c, f, n, e: (n * d / (c**2 + e)).sum()),
        "each entry of c_hat",
    ),
    ("relative_error_gradient", "root", relative(lambda d, c, f, n, e: n * d / np.sqrt(c**2 + e)), "the root"),
    (
        "relative_error_gradient",
        "constant",
        relative(lambda d, c, f, n, e: n * d / (c**2 + 0.01)),
        "epsilon is another",
    ),
    ("five_faults", "first wrong", "GFADB", "What is the derivative of e^-x?"),
    ("five_faults", "second wrong", "EDADB", "call it twice"),
    ("five_faults", "third wrong", "EFBDB", "say of rows and columns"),
    ("five_faults", "fourth wrong", ("E", "F", "A", "C", "B"), "a constant ratio"),
    ("five_faults", "fifth wrong", "efadc", "How many rows use it?"),
    ("five_faults", "no such letter", "XFADB", "none of the letters"),
    ("five_faults", "four letters", "EFAD", "5 letters"),
    ("five_faults", "a number", 5, "5 letters"),
    ("at_a_kink", "zero", lambda w, b: np.zeros(w.shape[1]), "it must be 0"),
    ("at_a_kink", "sign of the bias", lambda w, b: -on_the_boundary(w, b), "a sign of the bias flipped"),
    ("at_a_kink", "not squared", lambda w, b: -b[0] * w[0] / np.linalg.norm(w[0]), "nearest to its kink is"),
    ("at_a_kink", "NaN", lambda w, b: np.full(w.shape[1], np.nan), "must be finite"),
    ("at_a_kink", "a row for each neuron", lambda w, b: -b[:, np.newaxis] * w, "shape"),
    ("at_a_kink", "returns nothing", lambda w, b: None, "is the `return` missing"),
    (
        "rprop_step",
        "climbs",
        rprop_with(moved=lambda p, used, now, new, *_: p + used * new),
        "it climbs",
    ),
    ("rprop_step", "times gradient", rprop_with(moved=lambda p, u, now, new, old, g, s: p - new * g), "only its sign"),
    ("rprop_step", "old step", rprop_with(moved=lambda p, used, now, new, old, *_: p - used * old), "the step before"),
    ("rprop_step", "squared sign", rprop_with(moved=lambda p, used, now, new, *_: p - used**2 * new), "is squared"),
    ("rprop_step", "does not move", rprop_with(moved=lambda p, *_: p.copy()), "it does not move"),
    ("rprop_step", "never grows", rprop_with(factor=lambda a, g, s: np.where(a < 0, s, 1.0)), "it does not grow"),
    (
        "rprop_step",
        "exchanged",
        rprop_with(factor=lambda a, g, s: np.where(a < 0, g, np.where(a > 0, s, 1.0))),
        "grow and shrink are exchanged",
    ),
    ("rprop_step", "never shrinks", rprop_with(factor=lambda a, g, s: np.where(a > 0, g, 1.0)), "it stays as it was"),
    ("rprop_step", "grows at 0", rprop_with(factor=lambda a, g, s: np.where(a >= 0, g, s)), "it grows where one sign"),
    ("rprop_step", "shrinks at 0", rprop_with(factor=lambda a, g, s: np.where(a > 0, g, s)), "it shrinks where one"),
    (
        "rprop_step",
        "divides",
        rprop_with(factor=lambda a, g, s: np.where(a > 0, g, np.where(a < 0, 1 / s, 1.0))),
        "divided by shrink",
    ),
    ("rprop_step", "new sign kept", rprop_with(remembered=lambda now, *_: now), "the new sign is remembered"),
    (
        "rprop_step",
        "old sign kept",
        rprop_with(remembered=lambda now, agree, g, old: np.where(agree < 0, old, now)),
        "the old sign is kept",
    ),
    ("rprop_step", "gradient kept", rprop_with(remembered=lambda now, agree, g, old: g), "the gradient itself"),
    ("rprop_step", "product kept", rprop_with(remembered=lambda now, agree, *_: agree), "the product of both signs"),
    ("rprop_step", "moves at once", rprop_with(moved=lambda p, u, now, new, *_: p - now * new), "waits for one step"),
    (
        "rprop_step",
        "goes back",
        rprop_with(moved=lambda p, u, now, new, old, g, s: np.where(now * s < 0, p + s * old, p - u * new)),
        "it goes back",
    ),
    (
        "rprop_step",
        "goes on",
        rprop_with(moved=lambda p, u, now, new, old, g, s: np.where(now * s < 0, p - s * new, p - u * new)),
        "by the old sign",
    ),
    ("rprop_step", "no bounds", rprop_with(bounded=lambda step, *_: step), "the bounds are missing"),
    ("rprop_step", "no upper", rprop_with(bounded=lambda s, low, high: np.maximum(s, low)), "the largest step"),
    ("rprop_step", "no lower", rprop_with(bounded=lambda s, low, high: np.minimum(s, high)), "the smallest step"),
    ("rprop_step", "order", lambda *a: [rprop(*a)[k] for k in (0, 2, 1)], "the order is parameter, sign, step"),
    ("rprop_step", "one result", lambda *a: rprop(*a)[0], "3 things are needed"),
    ("rprop_step", "returns nothing", lambda *a: None, "is the `return` missing"),
    ("smallest_model", "the best", choose_with(pick=lambda good, m, p: int(m.argmin())), "that is the best mean"),
    ("smallest_model", "the smallest", choose_with(pick=lambda good, m, p: int(p.argmin())), "its error is too large"),
    ("smallest_model", "no root", choose_with(root=False), "divided by sqrt(folds)"),
    ("smallest_model", "ddof 0", choose_with(ddof=0), "ddof=1"),
    ("smallest_model", "own error", choose_with(own=True), "it is that of the best"),
    ("smallest_model", "largest", choose_with(pick=lambda g, m, p: int(g[p[g].argmax()])), "that is the best mean"),
    ("smallest_model", "last good one", choose_with(pick=lambda g, m, p: int(g[-1])), "take the smallest"),
    ("smallest_model", "its size", choose_with(pick=lambda g, m, p: int(p[g].min())), "its index is asked for"),
    ("smallest_model", "index among the good", choose_with(pick=lambda g, m, p: int(p[g].argmin())), "an index among"),
    ("smallest_model", "a list", lambda p, e: [choose(p, e)], "number"),
    ("smallest_model", "a fraction", lambda p, e: choose(p, e) + 0.5, "a whole number"),
    ("smallest_model", "returns nothing", lambda p, e: None, "is the `return` missing"),
)
RIGHT = {
    "used_twice": [-4.0, 8, -6],
    "linear": layer,
    "linear_backward": linear_right,
    "sigmoid_backward": lambda d_y, s: d_y * s * (1 - s),
    "softplus_backward": lambda d_y, x: d_y * stable(x),
    "relative_error_gradient": relative_right,
    "five_faults": "efadb",
    "at_a_kink": on_the_boundary,
    "rprop_step": rprop,
    "smallest_model": choose,
}
OTHER_IDEAS = (
    ("softplus_backward", "tanh", lambda d_y, x: d_y * (1 + np.tanh(x / 2)) / 2),
    ("softplus_backward", "logaddexp", lambda d_y, x: d_y * np.exp(-np.logaddexp(0, -x))),
    ("sigmoid_backward", "s - s^2", lambda d_y, s: d_y * (s - s**2)),
    ("at_a_kink", "one axis", along_one_axis),
    ("linear_backward", "einsum", backward_pass(d_weight=lambda d, x, w: np.einsum("is,it->st", d, x))),
    ("linear", "a list", lambda x, w, b: [[float(one @ row + c) for one, c in zip(w, b, strict=True)] for row in x]),
    ("smallest_model", "a NumPy number", lambda p, e: np.int64(choose(p, e))),
)


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


@pytest.mark.parametrize(("exercise", "idea", "answer"), OTHER_IDEAS, ids=[f"{e}: {i}" for e, i, _ in OTHER_IDEAS])
def test_every_right_idea_earns_every_point(exercise, idea, answer):
    assert_earns_every_point(exercise, answer)


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_every_exercise_has_a_right_answer_and_wrong_ones():
    names = {name for name, one in EXERCISES.items() if one.chapter == "ch08"}
    assert set(RIGHT) == {exercise for exercise, *_ in WRONG} == names


# --- the predictions are what the library says


def test_the_gradients_of_the_small_graph_are_those_of_the_library():
    x, y, z = (mcd.nn.Scalar(value) for value in (-2.0, 5.0, -4.0))
    found = backward((x + y) * (x * z))
    assert reference("used_twice") == tuple(found[one] for one in (x, y, z))


NOTEBOOK = ROOT / "notebooks" / "ch08_backprop.py"
SAID = {
    "A": "transpose",
    "B": "The sum over the batch is missing",
    "D": "is a factor of 2 missing?",
    "E": "The sign is flipped",
    "F": "overwrites its input",
}


@pytest.mark.parametrize("number", range(5))
def test_the_gradient_check_names_each_of_the_five_faults(number):
    pairs, inputs = load_answer(NOTEBOOK, "PAIRS"), load_answer(NOTEBOOK, "INPUTS")
    name, pair = list(pairs.items())[number]
    needed = pair[0].__code__.co_varnames[: pair[0].__code__.co_argcount]
    with pytest.raises(mcd.nn.GradientError) as caught:
        mcd.nn.check_gradient(pair, {one: inputs[one] for one in needed})
    assert str(caught.value).startswith(name)
    assert SAID[reference("five_faults")[number]] in str(caught.value)


def test_the_gradient_check_complains_at_the_kink_and_not_beside_it(rng):
    network = mcd.nn.MLP.random([2, 3, 1], hidden=mcd.nn.ReLU(), rng=rng)
    network = network.replace(network.parameters | {"bias_1": np.array([0.5, -0.3, 0.2])})
    x = reference("at_a_kink")(network.parameters["weight_1"], network.parameters["bias_1"])
    with pytest.raises(mcd.nn.GradientError, match="gradient of "):
        mcd.nn.check_gradient(network, {"x": x[np.newaxis]})
    assert mcd.nn.check_gradient(network, {"x": x[np.newaxis] + 0.01}) < 1e-6


def test_the_smallest_model_is_that_of_the_library(rng):
    for m in (1, 2, 9, 30):
        parameters = rng.permutation(np.arange(4, 4 + 3 * m, 3))
        errors = rng.gamma(4.0, 0.1, (m, 5)) + rng.uniform(0, 0.3, (m, 1))
        assert reference("smallest_model")(parameters, errors) == smallest_model(parameters.tolist(), errors)
