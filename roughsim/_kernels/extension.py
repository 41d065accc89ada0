"""Loops of the push–pull pyramid: the extension of a field from the free points to the plane, and its transpose.

Weights are 1 on the free points. A parent cell has the weight min(1, Σ/3) and the weighted mean of its (up to) four
children; on the way back u = w v + (1 − w)·(bilinear interpolation of the parents), periodic. The weights of the finest
level are the bytes of the free set, and its field is zero off the free points. Above it, level l lies at starts[l] in
flat arrays and has the shape shapes[l]. Where only one axis is halved, which the shapes say, a parent has two children
and the weight min(1, Σ/`WHOLE`), and the interpolation is linear: `_push_one`, `_gather_one`. These are compiled only
where some level needs them: `one_axis` is None elsewhere, and the compiler then leaves them out.

`extend` and `transpose` do some stages in one call: `stages` is a sum of `FIRST`, `UP`, `DOWN` and `LAST`, and `rows`
and `parent_rows` are start and stop at level 0 and above it.
"""

from typing import Any

import numpy as np

from roughsim._kernels import REORDER, kernel

FIRST, UP, DOWN, LAST = 1, 2, 4, 8  # at level 0, to the top, back from it, at level 0
WHOLE = 1.5  # children on which a parent has the full weight, of two


@kernel()
def push_finest(start: int, stop: int, free: Any, field: Any, weight: Any, value: Any, inverse: Any) -> None:
    """Fill the parent rows of the rows start … stop − 1 (start even): weight, mean, 1/Σ weights."""
    columns = field.shape[1]
    one, third, zero = field.dtype.type(1.0), field.dtype.type(1.0 / 3.0), field.dtype.type(0.0)
    for i in range(start, stop, 2):
        k = min(i + 1, field.shape[0] - 1)
        second = one if k > i else zero  # an odd last row has no partner
        bit = np.int8(1) if k > i else np.int8(0)
        row = i // 2
        # free points are counted as integers, and the field needs no weights: it is zero elsewhere
        for j in range(columns // 2):
            a, b = 2 * j, 2 * j + 1
            count = field.dtype.type(free[i, a] + free[i, b] + bit * (free[k, a] + free[k, b]))
            total = field[i, a] + field[i, b] + second * (field[k, a] + field[k, b])
            share = one / max(count, one) if count > zero else zero
            inverse[row, j] = share
            value[row, j] = total * share
            weight[row, j] = min(one, count * third)
        if columns % 2:  # an odd last column likewise
            j, a = columns // 2, columns - 1
            count = field.dtype.type(free[i, a] + bit * free[k, a])
            share = one / max(count, one) if count > zero else zero
            inverse[row, j] = share
            value[row, j] = (field[i, a] + second * field[k, a]) * share
            weight[row, j] = min(one, count * third)


@kernel(fastmath=REORDER)
def extend(stages: int, rows: Any, _: Any, bottom: int, free: Any, field: Any, parents: Any, pyramid: Any) -> None:
    """Extend a field from the free points, in place: push, the levels above, pull."""
    weight, value, inverse = parents
    if stages & FIRST:
        push_finest(rows[0], rows[1], free, field, weight, value, inverse)
    if stages & UP:
        push_coarse(bottom, *pyramid)
    if stages & DOWN:
        pull_coarse(bottom, *pyramid)
    if stages & LAST:
        pull(rows[0], rows[1], free, value, field)


@kernel(fastmath=REORDER)
def transpose(
    stages: int,
    rows: Any,
    parent_rows: Any,
    bottom: int,
    free: Any,
    field: Any,
    parents: Any,
    pyramid: Any,
    step: Any,
    response: Any,
) -> Any:
    """Gather a field onto the free points, in place, zero elsewhere: the transposes of pull, levels above, and push.

    The levels above are `UP` and `DOWN` at once.
    Return ⟨field, response⟩ and ⟨step, response⟩ over the free points of these rows.
    """
    _, value, inverse = parents
    if stages & FIRST:
        gather(parent_rows[0], parent_rows[1], free, field, value)
    if stages & UP:
        transpose_coarse(bottom, *pyramid)
    cross, own, zero = 0.0, 0.0, field.dtype.type(0.0)
    if stages & LAST:
        for i in range(rows[0], rows[1]):
            # the products of a row are summed while the row is in the cache
            scatter(i, i + 1, free, value, inverse, field)
            for j in range(field.shape[1]):
                cross += field[i, j] * response[i, j]
                own += step[i, j] * response[i, j] if free[i, j] else zero
    return cross, own


@kernel(fastmath=REORDER)
def scatter_load(start: int, stop: int, free: Any, parent: Any, inverse: Any, p: Any, cap: float, change: Any) -> Any:
    """Take what reaches the free points from their change.

    Return Σ clip(p + change, 0, cap) and how many free points stay between the bounds.
    """
    columns, zero = change.shape[1], change.dtype.type(0.0)
    line = np.zeros(columns, change.dtype)
    total, count = 0.0, 0
    for i in range(start, stop):
        k = i // 2
        for j in range(columns // 2):
            line[2 * j] = line[2 * j + 1] = inverse[k, j] * parent[k, j]
        if columns % 2:
            line[columns - 1] = inverse[k, columns // 2] * parent[k, columns // 2]
        for j in range(columns):
            stays = free[i, j] != 0
            change[i, j] -= line[j] if stays else zero
            x = p[i, j] + change[i, j]
            y = min(max(x, 0.0), cap)
            total += y
            count += 1 if (x == y) & stays else 0
    return total, count


@kernel()
def push_coarse(bottom: int, one_axis: Any, shapes: Any, starts: Any, weights: Any, inverses: Any, values: Any) -> None:
    """Push from the level `bottom` to the top: the mean of the children."""
    top = len(shapes) - 1
    for level in range(bottom, top):
        weight, value = _level(weights, shapes, starts, level), _level(values, shapes, starts, level)
        above = level + 1
        parent_weight, parent_value = _level(weights, shapes, starts, above), _level(values, shapes, starts, above)
        inverse = _level(inverses, shapes, starts, above)
        if one_axis is not None and not _both(shapes, level):
            _push_one(weight, value, parent_weight, parent_value, inverse)
            continue
        _push(weight, value, parent_weight, parent_value, inverse)


@kernel()
def pull_coarse(bottom: int, one_axis: Any, shapes: Any, starts: Any, weights: Any, inverses: Any, values: Any) -> None:
    """Pull from the top to the level `bottom`: what is left open comes from the level above."""
    for level in range(len(shapes) - 2, bottom - 1, -1):
        weight, value = _level(weights, shapes, starts, level), _level(values, shapes, starts, level)
        parent = _level(values, shapes, starts, level + 1)
        pull(0, weight.shape[0], weight, parent, value)


@kernel()
def transpose_coarse(
    bottom: int, one_axis: Any, shapes: Any, starts: Any, weights: Any, inverses: Any, sources: Any
) -> None:
    """Gather from the level `bottom` to the top and scatter back to it: the transpose of both steps."""
    top = len(shapes) - 1
    # the transposes of the steps down, in reverse order, then those of the steps up
    for level in range(bottom, top):
        weight, source = _level(weights, shapes, starts, level), _level(sources, shapes, starts, level)
        parent = _level(sources, shapes, starts, level + 1)
        if one_axis is not None and not _both(shapes, level):
            _gather_one(weight, source, parent)
            continue
        gather(0, parent.shape[0], weight, source, parent)
    for level in range(top - 1, bottom - 1, -1):
        weight, source = _level(weights, shapes, starts, level), _level(sources, shapes, starts, level)
        parent, inverse = _level(sources, shapes, starts, level + 1), _level(inverses, shapes, starts, level + 1)
        scatter(0, weight.shape[0], weight, parent, inverse, source)


@kernel(inline=True)
def _both(shapes: Any, level: int) -> bool:
    """Whether both axes are halved above this level; a lone row or column cannot be."""
    upper = level + 1
    return bool(shapes[upper, 0] < shapes[level, 0] and shapes[upper, 1] < shapes[level, 1])


@kernel()
def _level(flat: Any, shapes: Any, starts: Any, level: int) -> Any:
    """The field of a level, a view of the flat array."""
    rows, columns = shapes[level, 0], shapes[level, 1]
    return flat[starts[level] : starts[level] + rows * columns].reshape((rows, columns))


@kernel(inline=True)
def _push(weight: Any, value: Any, parent_weight: Any, parent_value: Any, parent_inverse: Any) -> None:
    rows, columns = weight.shape
    one, third, zero = value.dtype.type(1.0), value.dtype.type(1.0 / 3.0), value.dtype.type(0.0)
    for i in range(parent_weight.shape[0]):
        k = min(2 * i + 1, rows - 1)
        second = one if k > 2 * i else zero  # an odd last row has no partner
        for j in range(columns // 2):
            a, b = 2 * j, 2 * j + 1
            wa, wb, wc, wd = weight[2 * i, a], weight[2 * i, b], second * weight[k, a], second * weight[k, b]
            total = wa + wb + wc + wd
            mean = wa * value[2 * i, a] + wb * value[2 * i, b] + wc * value[k, a] + wd * value[k, b]
            share = one / total if total > zero else zero
            parent_inverse[i, j] = share
            parent_value[i, j] = mean * share
            parent_weight[i, j] = min(one, total * third)
        if columns % 2:
            j, a = columns // 2, columns - 1
            wa, wc = weight[2 * i, a], second * weight[k, a]
            share = one / (wa + wc) if wa + wc > zero else zero
            parent_inverse[i, j] = share
            parent_value[i, j] = (wa * value[2 * i, a] + wc * value[k, a]) * share
            parent_weight[i, j] = min(one, (wa + wc) * third)


@kernel(inline=True)
def pull(start: int, stop: int, weight: Any, parent: Any, value: Any) -> None:
    """Write w v + (1 − w)·(interpolation of the parents) in the rows start … stop − 1."""
    rows, columns = weight.shape
    parents, kind = parent.shape[1], parent.dtype.type
    high, wide = rows > parent.shape[0], columns > parents
    blended = np.empty(parents + 2, parent.dtype)  # a parent more, periodic, at each end
    one, big, small = kind(1.0), kind(0.75), kind(0.25)
    for i in range(start, stop):
        # interpolate across the rows first: one line of parents, from which the children of the row are read
        near, side = _parents(i, parent.shape[0], high)
        for j in range(parents):
            blended[j + 1] = big * parent[near, j] + small * parent[side, j]
        blended[0], blended[parents + 1] = blended[parents], blended[1]
        if not wide:
            for j in range(columns):
                w = kind(weight[i, j])
                value[i, j] = w * value[i, j] + (one - w) * blended[j + 1]
            continue
        # then along the row: the left child leans on the parent to the left, the right one on that to the right
        for j in range(columns // 2):
            a, b = 2 * j, 2 * j + 1
            wa, wb, middle = kind(weight[i, a]), kind(weight[i, b]), big * blended[j + 1]
            value[i, a] = wa * value[i, a] + (one - wa) * (middle + small * blended[j])
            value[i, b] = wb * value[i, b] + (one - wb) * (middle + small * blended[j + 2])
        if columns % 2:
            a, w = columns - 1, kind(weight[i, columns - 1])
            value[i, a] = w * value[i, a] + (one - w) * (big * blended[parents] + small * blended[parents - 1])


@kernel()
def gather(start: int, stop: int, weight: Any, source: Any, parent: Any) -> None:
    """Fill the parent rows start … stop − 1 with the transpose of the bilinear part of `pull`."""
    (rows, columns), (high, wide) = source.shape, parent.shape
    kind = source.dtype.type
    line = np.zeros(2 * wide + 2, source.dtype)
    one, big, small = kind(1.0), kind(0.75), kind(0.25)
    for i in range(start, stop):
        # sum the four child rows that lean on this parent row
        for j in range(2 * wide + 2):
            line[j] = 0.0
        for k in range(4):
            row = (2 * i - 1 + k) % (2 * high)
            if row < rows:  # the doubled parents have one row more than an odd number of children
                share = small if k in (0, 3) else big
                for j in range(columns):
                    line[j + 1] += share * (one - kind(weight[row, j])) * source[row, j]
        # and likewise along the row: child j of the doubled parents is at line[j + 1]
        line[0], line[2 * wide + 1] = line[2 * wide], line[1]
        for j in range(wide):
            parent[i, j] = big * (line[2 * j + 1] + line[2 * j + 2]) + small * (line[2 * j] + line[2 * j + 3])


@kernel()
def scatter(start: int, stop: int, weight: Any, parent: Any, inverse: Any, source: Any) -> None:
    """Write w (source + what the parent has for its children) in the rows start … stop − 1: the push transposed."""
    rows, columns = source.shape
    kind, high, wide = source.dtype.type, rows > parent.shape[0], columns > parent.shape[1]
    for i in range(start, stop):
        k = i // 2 if high else i
        if not wide:
            for j in range(columns):
                source[i, j] = kind(weight[i, j]) * (source[i, j] + inverse[k, j] * parent[k, j])
            continue
        # both children of a parent at once; an odd last column is an only child
        for j in range(columns // 2):
            a, b, share = 2 * j, 2 * j + 1, inverse[k, j] * parent[k, j]
            source[i, a] = kind(weight[i, a]) * (source[i, a] + share)
            source[i, b] = kind(weight[i, b]) * (source[i, b] + share)
        if columns % 2:
            j, a = columns // 2, columns - 1
            source[i, a] = kind(weight[i, a]) * (source[i, a] + inverse[k, j] * parent[k, j])


@kernel(inline=True)
def _push_one(weight: Any, value: Any, parent_weight: Any, parent_value: Any, parent_inverse: Any) -> None:
    """Fill the parents: weight min(1, Σ/`WHOLE`), weighted mean, 1/Σ weights."""
    rows, columns = weight.shape
    high, wide = rows > parent_weight.shape[0], columns > parent_weight.shape[1]
    one, zero, share = value.dtype.type(1.0), value.dtype.type(0.0), value.dtype.type(1.0 / WHOLE)
    totals, sums = np.empty(columns + 1, value.dtype), np.empty(columns + 1, value.dtype)
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
            total, mean = totals[j], sums[j]
            if wide:
                total, mean = totals[2 * j] + totals[2 * j + 1], sums[2 * j] + sums[2 * j + 1]
            inverse = one / total if total > zero else zero
            parent_inverse[i, j] = inverse
            parent_value[i, j] = mean * inverse
            parent_weight[i, j] = min(one, total * share)


@kernel(inline=True)
def _gather_one(weight: Any, source: Any, parent: Any) -> None:
    """Fill the parents with the transpose of the linear part of `pull`."""
    rows, columns = source.shape
    wide = columns > parent.shape[1]
    one, big, small = source.dtype.type(1.0), source.dtype.type(0.75), source.dtype.type(0.25)
    parent[:, :] = 0.0
    for i in range(rows):
        # three quarters go to the parent, a quarter to the parent beside it, along the axis that is halved
        above, beside = _parents(i, parent.shape[0], not wide)
        for j in range(columns):
            near, side = _parents(j, parent.shape[1], wide)
            open_share = (one - weight[i, j]) * source[i, j]
            parent[above, near] += big * open_share
            parent[beside, side] += small * open_share


@kernel(inline=True)
def _parents(child: int, parents: int, halved: bool) -> Any:
    """The parent of a child and the parent beside it, periodic; the child itself, twice, if the axis is not halved."""
    if not halved:
        return child, child
    near = child // 2
    return near, (near + 2 * (child % 2) - 1) % parents
