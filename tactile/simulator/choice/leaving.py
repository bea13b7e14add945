"""What can be left out: effects in an order, the dear ones first, as long as their bounds together stay small."""

from tactile.simulator.choice.effect_bounds import EffectBounds
from tactile.simulator.choice.finger_bounds import FIELD, LeftOut


def negligible(bounds: EffectBounds, tolerance: float, rough: bool) -> tuple[set[str], float]:
    """What can be left out, with ``FIELD`` if it may be the field's accuracy, and the bound of the error."""
    sizes, zero = bounds.sizes(), bounds.zero
    fields = {name for name, _ in bounds.on_fields}
    tried = {name for one in bounds.fingers for name in one.terms}
    # what is too large alone is not left out, but for what was tried, which may cancel
    small = [(size, name) for name, size in sizes.items() if size <= tolerance or name in tried]
    small.sort()
    order = [name for _, name in small if name in fields]
    order += [name for _, name in small if name not in fields and name not in zero]
    if rough and fields:
        order.insert(0, FIELD)
    off, joint = _left_out(bounds, order, fields, tolerance)
    while bounds.bends(off):
        joint = bounds.without(off).change(off)
        if joint <= tolerance:
            break
        # it does more beside the others than alone, as Poisson's ratio at the bottom of a layer
        order.remove(max(off & fields, key=lambda name: sizes[name]))
        off, joint = _left_out(bounds, order, fields, tolerance)
    return off, joint


def _left_out(bounds: EffectBounds, order: list[str], fields: set[str], tolerance: float) -> tuple[set[str], float]:
    """What can be left out of the effects in an order, and the bound of the error."""
    off, joint, stepped = _greedy(bounds, order, tolerance)
    if not stepped:
        return off, joint
    # where a converter's steps are coarse nothing before it may be left out, or the converter itself
    steps = bounds.converters
    more, change, _ = _greedy(bounds, sorted(order, key=lambda name: name not in steps), tolerance)
    return max((off, joint), (more, change), key=lambda one: (len(one[0] & fields), len(one[0])))


def _greedy(bounds: EffectBounds, order: list[str], tolerance: float) -> tuple[set[str], float, bool]:
    """What can be left out in an order, the bound of the error, and whether steps behind it let one stay."""
    fingers, most, joint, stepped = bounds.fingers, tolerance * bounds.peak, 0.0, False
    left, off = [LeftOut()] * len(fingers), set(bounds.zero)
    for name in order:
        more, change, smooth = [], 0.0, 0.0
        for finger, gone in zip(fingers, left, strict=True):
            one = finger.without(gone, name, off)
            more.append(one)
            change, smooth = max(change, one.stepped), max(smooth, one.change)
        if change <= most:
            left, joint = more, change
            off.add(name)
        elif smooth <= most:
            stepped = True
    return off, joint / bounds.peak, stepped
