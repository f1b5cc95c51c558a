"""The fast twin of a network's forward and backward pass, in float32: 256 rows of a batch at a time, within the cache.

Inside a block everything is planar, one plane of 256 numbers for each input or neuron, so that all loops run over the
batch. Nothing is kept between the passes: the backward pass begins with the forward pass of its block, which costs less
than to write down what that found and read it again. Each block has gradients of its own, added up in order: the bits do
not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numba import prange

from mcdenoise.kernels.jit import kernel
from mcdenoise.kernels.rows import ZERO, exp2, place

BLOCK = 256
PLANE = BLOCK + 16  # from one plane to the next: at a power of two all planes would share a few places of the cache
LENGTH, STEP = place(BLOCK), place(PLANE)
NONE, SIGMOID, TANH, RELU, SOFTPLUS = range(5)
ONE, TWO, NOTHING = np.float32(1), np.float32(2), np.float32(0)
LOG2_E = np.float32(np.log2(np.e))
L3, L5, L7, L9, L11, L13 = (np.float32(1 / k) for k in (3, 5, 7, 9, 11, 13))


def network_forward(
    x: np.ndarray, parameters: np.ndarray, widths: Sequence[int], activations: Sequence[int]
) -> np.ndarray:
    """The output (n, d_out) of a network.

    Parameters
    ----------
    x : (n, d_in) float32
    parameters : (size,) float32, weight and bias of the first layer, then of the next
    widths : of the input, and of the output of each layer
    activations : behind each layer, one of NONE, SIGMOID, TANH, RELU, SOFTPLUS

    Examples
    --------
    >>> network_forward(np.ones((1, 2), np.float32), np.array([1, 2, 3], np.float32), (2, 1), (NONE,))
    array([[6.]], dtype=float32)
    """
    y = np.empty((len(x), widths[-1]), np.float32)
    flat = np.ascontiguousarray(x, np.float32).ravel()
    forward_blocks(y.ravel(), flat, parameters, np.array(widths), np.array(activations), len(x))
    return y


def network_backward(
    d_y: np.ndarray, x: np.ndarray, parameters: np.ndarray, widths: Sequence[int], activations: Sequence[int]
) -> np.ndarray:
    """Gradients of all parameters, flat, from d_y (n, d_out) and what `network_forward` was given.

    Examples
    --------
    >>> x, parameters = np.ones((2, 2), np.float32), np.array([1, 2, 3], np.float32)
    >>> network_backward(np.ones((2, 1), np.float32), x, parameters, (2, 1), (NONE,))
    array([2., 2., 2.], dtype=float32)
    """
    each = np.empty((-(-len(x) // BLOCK), len(parameters)), np.float32)
    flat = [np.ascontiguousarray(one, np.float32).ravel() for one in (d_y, x)]
    backward_blocks(each.ravel(), *flat, parameters, np.array(widths), np.array(activations), len(x))
    return each.sum(axis=0, dtype=np.float64).astype(np.float32)


@kernel(parallel=True)
def forward_blocks(y, x, parameters, widths, activations, rows):
    """Run each block of rows through all layers."""
    for block in prange((rows + BLOCK - 1) // BLOCK):
        count = min(BLOCK, rows - block * BLOCK)
        before, inputs = np.empty(widths[1:].sum() * PLANE, np.float32), np.empty(widths.max() * PLANE, np.float32)
        first = np.empty(widths[0] * PLANE, np.float32)
        gather(first, x, block * BLOCK, count, widths[0])
        forward_block(before, first, inputs, parameters, widths, activations)
        scatter(y, inputs, block * BLOCK, count, widths[-1])


@kernel(parallel=True)
def backward_blocks(gradients, d_y, x, parameters, widths, activations, rows):
    """Run each block of rows through all layers and back."""
    for block in prange((rows + BLOCK - 1) // BLOCK):
        count, widest = min(BLOCK, rows - block * BLOCK), widths.max() * PLANE
        before, inputs = np.empty(widths[1:].sum() * PLANE, np.float32), np.empty(widest, np.float32)
        d_after, d_input = np.empty(widest, np.float32), np.empty(widest, np.float32)
        first = np.empty(widths[0] * PLANE, np.float32)
        gather(first, x, block * BLOCK, count, widths[0])
        forward_block(before, first, inputs, parameters, widths, activations)
        gather(d_after, d_y, block * BLOCK, count, widths[-1])
        own = place(block * parameters.size)
        backward_block(gradients, own, d_after, d_input, first, inputs, before, parameters, widths, activations)


@kernel
def forward_block(before, first, inputs, parameters, widths, activations):
    """One block: a layer is a sum for each neuron, then its activation, which becomes the next layer's input."""
    at, neuron, source = 0, 0, first
    for layer in range(activations.size):
        d_in, d_out = widths[layer], widths[layer + 1]
        for s in range(d_out):
            bias = parameters[at + d_out * d_in + s]
            add_inputs(before, place((neuron + s) * PLANE), parameters, at + s * d_in, bias, source, d_in)
        for s in range(d_out):
            activate(inputs, place(s * PLANE), before, place((neuron + s) * PLANE), activations[layer])
        at += d_out * (d_in + 1)
        neuron += d_out
        source = inputs


@kernel
def backward_block(gradients, own, d_after, d_input, first, inputs, before, parameters, widths, activations):
    """One block: from d_y through each activation, then to the layer's parameters and to its input."""
    at, neuron = parameters.size, widths[1:].sum()
    for layer in range(activations.size - 1, -1, -1):
        d_in, d_out = widths[layer], widths[layer + 1]
        at -= d_out * (d_in + 1)
        neuron -= d_out
        for s in range(d_out):
            multiply_by_slope(d_after, place(s * PLANE), before, place((neuron + s) * PLANE), activations[layer])
        if layer == 0:
            inputs = first
        else:
            for t in range(d_in):
                activate(inputs, place(t * PLANE), before, place((neuron - d_in + t) * PLANE), activations[layer - 1])
        for s in range(d_out):
            weigh_inputs(gradients, own + place(at + s * d_in), d_after, place(s * PLANE), inputs, d_in)
            gradients[own + place(at + d_out * d_in + s)] = total(d_after, place(s * PLANE))
        if layer > 0:
            for t in range(d_in):
                add_outputs(d_input, place(t * PLANE), parameters, at + t, d_in, d_after, d_out)
            d_after, d_input = d_input, d_after


@kernel
def gather(planar, rows, first, count, columns):
    """Turn some rows of a batch into planes; what is missing of the block is 0."""
    if count < BLOCK:
        planar[: columns * PLANE] = NOTHING
    at, width = place(first * columns), place(columns)
    for i in range(ZERO, place(count)):
        to = i
        for t in range(ZERO, width):
            planar[to] = rows[at + t]
            to += STEP
        at += width


@kernel
def scatter(rows, planar, first, count, columns):
    """Turn planes into rows again."""
    at, width = place(first * columns), place(columns)
    for i in range(ZERO, place(count)):
        of = i
        for t in range(ZERO, width):
            rows[at + t] = planar[of]
            of += STEP
        at += width


@kernel
def add_inputs(before, at, parameters, weight, bias, inputs, d_in):
    """before = bias + sum over t of weight_t input_t, four inputs at a time."""
    for i in range(ZERO, LENGTH):
        before[at + i] = bias
    whole = d_in // 4 * 4
    for t in range(0, whole, 4):
        w = parameters[weight + t : weight + t + 4]
        add_four_scaled(before, at, w[0], w[1], w[2], w[3], inputs, place(t * PLANE))
    for t in range(whole, d_in):
        add_scaled(before, at, parameters[weight + t], inputs, place(t * PLANE))


@kernel
def add_outputs(d_input, at, parameters, weight, d_in, d_after, d_out):
    """d_input_t = sum over s of weight_{s,t} d_after_s, four outputs at a time."""
    for i in range(ZERO, LENGTH):
        d_input[at + i] = NOTHING
    whole = d_out // 4 * 4
    for s in range(0, whole, 4):
        a, b = parameters[weight + s * d_in], parameters[weight + (s + 1) * d_in]
        c, d = parameters[weight + (s + 2) * d_in], parameters[weight + (s + 3) * d_in]
        add_four_scaled(d_input, at, a, b, c, d, d_after, place(s * PLANE))
    for s in range(whole, d_out):
        add_scaled(d_input, at, parameters[weight + s * d_in], d_after, place(s * PLANE))


@kernel
def weigh_inputs(gradients, at, d_after, neuron, inputs, d_in):
    """gradient_t = sum over the block of d_after input_t, four inputs at a time."""
    whole = d_in // 4 * 4
    for t in range(0, whole, 4):
        to = at + place(t)
        found = dot_four(d_after, neuron, inputs, place(t * PLANE))
        gradients[to], gradients[to + place(1)], gradients[to + place(2)], gradients[to + place(3)] = found
    for t in range(whole, d_in):
        gradients[at + place(t)] = dot(d_after, neuron, inputs, place(t * PLANE))


@kernel
def add_four_scaled(row, at, a, b, c, d, planes, there):
    """row += a, b, c, d times four planes one after the other."""
    second, third, fourth = there + STEP, there + STEP + STEP, there + STEP + STEP + STEP
    for i in range(ZERO, LENGTH):
        row[at + i] += a * planes[there + i] + b * planes[second + i] + c * planes[third + i] + d * planes[fourth + i]


@kernel
def add_scaled(row, at, factor, planes, there):
    """row += factor plane."""
    for i in range(ZERO, LENGTH):
        row[at + i] += factor * planes[there + i]


@kernel
def dot_four(row, at, planes, there):
    """Products of a plane with four that lie one after the other, summed over the block."""
    second, third, fourth = there + STEP, there + STEP + STEP, there + STEP + STEP + STEP
    a = b = c = d = NOTHING
    for i in range(ZERO, LENGTH):
        a += row[at + i] * planes[there + i]
        b += row[at + i] * planes[second + i]
        c += row[at + i] * planes[third + i]
        d += row[at + i] * planes[fourth + i]
    return a, b, c, d


@kernel
def dot(row, at, planes, there):
    """Product of two planes, summed over the block."""
    found = NOTHING
    for i in range(ZERO, LENGTH):
        found += row[at + i] * planes[there + i]
    return found


@kernel
def total(row, at):
    """Sum over the block."""
    found = NOTHING
    for i in range(ZERO, LENGTH):
        found += row[at + i]
    return found


@kernel
def activate(row, at, before, there, activation):
    """row = activation of what is before it."""
    if activation == SIGMOID:
        for i in range(ZERO, LENGTH):
            e = exp2(-abs(before[there + i]) * LOG2_E)
            row[at + i] = (ONE if before[there + i] > NOTHING else e) / (ONE + e)
    elif activation == TANH:
        for i in range(ZERO, LENGTH):
            e = exp2(-abs(before[there + i]) * TWO * LOG2_E)
            t = (ONE - e) / (ONE + e)
            row[at + i] = t if before[there + i] > NOTHING else -t
    elif activation == RELU:
        for i in range(ZERO, LENGTH):
            row[at + i] = max(before[there + i], NOTHING)
    elif activation == SOFTPLUS:
        for i in range(ZERO, LENGTH):  # log(1 + e) = 2 atanh(s) with s = e / (2 + e), at most 1/3
            e = exp2(-abs(before[there + i]) * LOG2_E)
            s = e / (TWO + e)
            q = s * s
            series = ONE + q * (L3 + q * (L5 + q * (L7 + q * (L9 + q * (L11 + q * L13)))))
            row[at + i] = max(before[there + i], NOTHING) + TWO * s * series
    else:
        for i in range(ZERO, LENGTH):
            row[at + i] = before[there + i]


@kernel
def multiply_by_slope(row, at, before, there, activation):
    """row *= derivative of the activation at what is before it."""
    if activation == SIGMOID:
        for i in range(ZERO, LENGTH):
            e = exp2(-abs(before[there + i]) * LOG2_E)
            row[at + i] *= e / ((ONE + e) * (ONE + e))
    elif activation == TANH:
        for i in range(ZERO, LENGTH):
            e = exp2(-abs(before[there + i]) * TWO * LOG2_E)
            row[at + i] *= TWO * TWO * e / ((ONE + e) * (ONE + e))
    elif activation == RELU:
        for i in range(ZERO, LENGTH):
            row[at + i] = row[at + i] if before[there + i] > NOTHING else NOTHING
    elif activation == SOFTPLUS:
        for i in range(ZERO, LENGTH):
            e = exp2(-abs(before[there + i]) * LOG2_E)
            row[at + i] *= (ONE if before[there + i] > NOTHING else e) / (ONE + e)
