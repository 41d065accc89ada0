"""Loops of the push–pull pyramid: the extension of a field from the free points to the plane, and its transpose.

Weights are 1 on the free points. A parent cell has the weight min(1, Σ/3) and the weighted mean of its (up to) four
children; on the way back u = w v + (1 − w)·(bilinear interpolation of the parents), periodic. The weights of the finest
level are the bytes of the free set, and its field is zero off the free points. Above it, levels[l] holds the start,
rows and columns of level l in flat arrays. If only one axis is halved from a level to the next, a parent has two
children and the weight min(1, Σ/`WHOLE`), and the interpolation is linear.

`extend` and `transpose` do some stages in one call: `stages` is a sum of `FIRST`, `UP`, `DOWN` and `LAST`, and `rows`
are start and stop at level 0, then above it. All other loops are built into these two: compiled by itself, each of them
would be optimised once more with every kernel that calls it. `line` and `doubled` are buffers for one row: of two
points for each column of the parents at level 0, and two more.
"""

import numpy as np

from roughsim._kernels import REORDER, kernel

FIRST, UP, DOWN, LAST = 1, 2, 4, 8  # at level 0, to the top, back from it, at level 0
WHOLE = 1.5  # children on which a parent has the full weight, of two


@kernel()
def _plane(flat, levels, i):
    """The plane of level i in a flat array."""
    start, rows, columns = levels[i]
    return flat[start : start + rows * columns].reshape(rows, columns)


@kernel(fastmath=REORDER)
def extend(stages, rows, _, bottom, free, field, parents, pyramid):
    """Extend a field from the free points, in place: push, the levels above, pull."""
    weight, value, inverse = parents
    levels, weights, inverses, values = pyramid
    top = len(levels) - 1
    # made here: the compiler then proves that these do not overlap, and the loops of `pull` are a third faster
    size = 2 * value.shape[1] + 2
    line = np.empty(size, value.dtype)
    doubled = np.empty(size, value.dtype)
    if stages & FIRST:
        _push_finest(rows[0], rows[1], free, field, weight, value, inverse)
    if stages & UP:
        for i in range(bottom, top):
            weight = _plane(weights, levels, i)
            value = _plane(values, levels, i)
            above = _plane(weights, levels, i + 1)
            mean = _plane(values, levels, i + 1)
            push(weight, value, above, mean, _plane(inverses, levels, i + 1), line, doubled)
    if stages & DOWN:
        for i in range(top - 1, bottom - 1, -1):
            weight = _plane(weights, levels, i)
            value = _plane(values, levels, i)
            pull(0, weight.shape[0], weight, _plane(values, levels, i + 1), value, line, doubled)
    if stages & LAST:
        pull(rows[0], rows[1], free, parents[1], field, line, doubled)


@kernel(fastmath=REORDER)
def transpose(
    stages,
    rows,
    line,
    bottom,
    free,
    field,
    parents,
    pyramid,
    step,
    response,
):
    """Gather a field onto the free points, in place, zero elsewhere: the transposes of pull, levels above, and push.

    Return ⟨field, response⟩ and ⟨step, response⟩ over the free points of these rows.
    """
    _, value, inverse = parents
    levels, weights, inverses, sources = pyramid
    top = len(levels) - 1
    if stages & FIRST:
        gather(rows[2], rows[3], free, field, value, line)
    # the transposes of the steps down, in reverse order, then of the steps up
    if stages & UP:
        for i in range(bottom, top):
            parent = _plane(sources, levels, i + 1)
            weight = _plane(weights, levels, i)
            source = _plane(sources, levels, i)
            gather(0, parent.shape[0], weight, source, parent, line)
    if stages & DOWN:
        for i in range(top - 1, bottom - 1, -1):
            weight = _plane(weights, levels, i)
            source = _plane(sources, levels, i)
            parent = _plane(sources, levels, i + 1)
            share = _plane(inverses, levels, i + 1)
            for k in range(source.shape[0]):
                scatter(k, weight, parent, share, source, line)
    cross = 0.0
    own = 0.0
    zero = field.dtype.type(0.0)
    if stages & LAST:
        for i in range(rows[0], rows[1]):
            # the products of a row are summed while the row is in the cache
            scatter(i, free, value, inverse, field, line)
            for j in range(field.shape[1]):
                cross += field[i, j] * response[i, j]
                own += step[i, j] * response[i, j] if free[i, j] else zero
    return cross, own


@kernel(inline=True)
def _push_finest(start, stop, free, field, weight, value, inverse):
    """Fill the parent rows of the rows start … stop − 1 (start even): weight, mean, 1/Σ weights."""
    columns = field.shape[1]
    one = field.dtype.type(1.0)
    third = field.dtype.type(1.0 / 3.0)
    zero = field.dtype.type(0.0)
    for i in range(start, stop, 2):
        k = min(i + 1, field.shape[0] - 1)
        second = one if k > i else zero  # an odd last row has no partner
        bit = np.int8(1) if k > i else np.int8(0)
        row = i // 2
        # free points are counted as integers, and the field needs no weights: it is zero elsewhere
        for j in range(columns // 2):
            a = 2 * j
            b = 2 * j + 1
            count = field.dtype.type(free[i, a] + free[i, b] + bit * (free[k, a] + free[k, b]))
            total = field[i, a] + field[i, b] + second * (field[k, a] + field[k, b])
            share = one / max(count, one) if count > zero else zero
            inverse[row, j] = share
            value[row, j] = total * share
            weight[row, j] = min(one, count * third)
        if columns % 2:  # an odd last column likewise
            j = columns // 2
            a = columns - 1
            count = field.dtype.type(free[i, a] + bit * free[k, a])
            share = one / max(count, one) if count > zero else zero
            inverse[row, j] = share
            value[row, j] = (field[i, a] + second * field[k, a]) * share
            weight[row, j] = min(one, count * third)


@kernel(inline=True)
def push(
    weight,
    value,
    parent_weight,
    parent_value,
    parent_inverse,
    totals,
    sums,
):
    """Fill the parents: weight, weighted mean, 1/Σ weights; `totals` and `sums` are buffers for one row."""
    rows, columns = weight.shape
    high = rows > parent_weight.shape[0]
    wide = columns > parent_weight.shape[1]
    one = value.dtype.type(1.0)
    zero = value.dtype.type(0.0)
    part = value.dtype.type(1.0 / 3.0 if high and wide else 1.0 / WHOLE)
    totals[columns], sums[columns] = zero, zero  # the partner of an odd last column
    for i in range(parent_weight.shape[0]):
        first, second = (2 * i, 2 * i + 1) if high else (i, rows)
        # sum across the rows if they are halved, then along the row if it is
        for j in range(columns):
            totals[j] = weight[first, j]
            sums[j] = weight[first, j] * value[first, j]
        if second < rows:
            for j in range(columns):
                totals[j] += weight[second, j]
                sums[j] += weight[second, j] * value[second, j]
        for j in range(parent_weight.shape[1]):
            if wide:
                parent_inverse[i, j] = totals[2 * j] + totals[2 * j + 1]
                parent_value[i, j] = sums[2 * j] + sums[2 * j + 1]
            else:
                parent_inverse[i, j] = totals[j]
                parent_value[i, j] = sums[j]
        for j in range(parent_weight.shape[1]):
            total = parent_inverse[i, j]
            inverse = one / total if total > zero else zero
            parent_inverse[i, j] = inverse
            parent_value[i, j] *= inverse
            parent_weight[i, j] = min(one, total * part)


@kernel(inline=True)
def pull(start, stop, weight, parent, value, line, doubled):
    """Write w v + (1 − w)·(interpolation of the parents) in the rows start … stop − 1."""
    columns = weight.shape[1]
    height, width = parent.shape
    kind = parent.dtype.type
    high = weight.shape[0] > height
    wide = columns > width
    one = kind(1.0)
    big = kind(0.75)
    small = kind(0.25)
    for i in range(start, stop):
        # interpolate across the rows first: one line of parents, with one more, periodic, at each end
        near = i // 2 if high else i
        side = (near + 2 * (i % 2) - 1) % height if high else i
        for j in range(width):
            line[j + 1] = big * parent[near, j] + small * parent[side, j]
        line[0], line[width + 1] = line[width], line[1]
        # then along the row: the left child leans on the parent to the left, the right one on that to the right
        for j in range(width):
            if wide:
                doubled[2 * j] = big * line[j + 1] + small * line[j]
                doubled[2 * j + 1] = big * line[j + 1] + small * line[j + 2]
            else:
                doubled[j] = line[j + 1]
        for j in range(columns):
            w = kind(weight[i, j])
            value[i, j] = w * value[i, j] + (one - w) * doubled[j]


@kernel(inline=True)
def gather(start, stop, weight, source, parent, line):
    """Fill the parent rows start … stop − 1 with the transpose of the interpolation in `pull`."""
    rows, columns = source.shape
    height, width = parent.shape
    kind = source.dtype.type
    high = rows > height
    wide = columns > width
    one = kind(1.0)
    big = kind(0.75)
    small = kind(0.25)
    zero = kind(0.0)
    for i in range(start, stop):
        # sum the four child rows that lean on this parent row
        for j in range(2 * width + 2):
            line[j] = zero
        for k in range(4 if high else 1):
            row = (2 * i - 1 + k) % (2 * height) if high else i
            if row < rows:  # the doubled parents have one row more than an odd number of children
                share = (small if (k == 0) | (k == 3) else big) if high else one
                for j in range(columns):
                    line[j + 1] += share * (one - kind(weight[row, j])) * source[row, j]
        # and likewise along the row: child j of the doubled parents is at line[j + 1]
        line[0], line[2 * width + 1] = line[2 * width], line[1]
        for j in range(width):
            if wide:
                parent[i, j] = big * (line[2 * j + 1] + line[2 * j + 2]) + small * (
                    line[2 * j] + line[2 * j + 3]
                )
            else:
                parent[i, j] = line[j + 1]


@kernel(inline=True)
def scatter(i, weight, parent, inverse, source, line):
    """Write w (source + share of the parent) in row i: the push transposed."""
    kind = source.dtype.type
    columns = source.shape[1]
    width = parent.shape[1]
    k = i // 2 if source.shape[0] > parent.shape[0] else i
    for j in range(width):
        if columns > width:
            line[2 * j] = line[2 * j + 1] = inverse[k, j] * parent[k, j]
        else:
            line[j] = inverse[k, j] * parent[k, j]
    for j in range(columns):
        source[i, j] = kind(weight[i, j]) * (source[i, j] + line[j])


@kernel(fastmath=REORDER)
def scatter_load(
    start,
    stop,
    line,
    free,
    parent,
    inverse,
    p,
    cap,
    change,
):
    """Subtract the result at the free points from their change; `line` is a buffer for one row.

    Return Σ clip(p + change, 0, cap) and how many free points stay between the bounds.
    """
    width = parent.shape[1]
    zero = change.dtype.type(0.0)
    total = 0.0
    count = 0
    for i in range(start, stop):
        k = i // 2
        for j in range(width):
            line[2 * j] = line[2 * j + 1] = inverse[k, j] * parent[k, j]
        for j in range(change.shape[1]):
            stays = free[i, j] != 0
            change[i, j] -= line[j] if stays else zero
            x = p[i, j] + change[i, j]
            y = min(max(x, 0.0), cap)
            total += y
            count += 1 if (x == y) & stays else 0
    return total, count
