"""What fails on a cutting table: drives, encoders, switches, wires, the axes themselves."""

from beamcam.controllers.simotion.axes import Axis

from .plant import Deed, Plant


def disable(index: int) -> Deed:
    """The drive of an axis drops out: it runs out by itself."""

    def deed(plant: Plant) -> None:
        axis = plant.axes[index]
        axis.stop()
        axis.enabled = False

    return deed


def alarm(index: int) -> Deed:
    """An axis reports a fault."""

    def deed(plant: Plant) -> None:
        axis = plant.axes[index]
        axis.stop()
        axis.error = True

    return deed


def alarm_that_stays(index: int, cycles: int) -> Deed:
    """A fault whose cause goes away so many cycles after it was acknowledged."""

    def deed(plant: Plant) -> None:
        alarm(index)(plant)
        axis = plant.axes[index]

        def reset() -> int:
            def late(plant: Plant) -> None:
                axis.error = False

            plant.script[plant.count + cycles] = late
            return 0

        axis.reset = reset  # type: ignore[method-assign]

    return deed


def close(index: int) -> Deed:
    """A limit switch closes."""
    return lambda plant: plant.closed.add(index)


def freeze(index: int) -> Deed:
    """An encoder tells one place for good; the belt may be torn."""

    def deed(plant: Plant) -> None:
        axis: Axis = plant.axes[index]
        plant.frozen[axis.name] = axis.actual

    return deed


def displace(index: int, by: float) -> Deed:
    """An encoder tells a place so far from the true one."""

    def deed(plant: Plant) -> None:
        plant.astray[plant.axes[index].name] = by

    return deed


def creep(index: int, mm_s: float) -> Deed:
    """An axis drifts from its set position, and its drive says nothing."""

    def deed(plant: Plant) -> None:
        plant.creeps[plant.axes[index].name] = mm_s

    return deed


def release(index: int) -> Deed:
    """A limit switch tells nothing."""
    return lambda plant: plant.loose.add(index)


def reverse(index: int) -> Deed:
    """An axis runs the wrong way."""

    def deed(plant: Plant) -> None:
        axis = plant.axes[index]
        run, go = axis.run, axis.go
        axis.run = lambda v, a: run(-v, a)  # type: ignore[method-assign]
        axis.go = lambda to, *limits: go(2 * axis.position - to, *limits)  # type: ignore[method-assign]

    return deed


def override(share: float) -> Deed:
    """Set positions go on at a share of their speed, as by an override of the operator panel."""

    def deed(plant: Plant) -> None:
        for one in (*plant.axes, *filter(None, [plant.path])):
            real = type(one).advance.__get__(one)
            one.advance = lambda s, real=real: real(share * s)  # type: ignore[method-assign]

    return deed


def press_stop(plant: Plant) -> None:
    """The stop button is pressed, and stays so."""
    plant.stop = True


def break_wire(index: int) -> Deed:
    """The wire of an input breaks."""
    return lambda plant: plant.broken.add(index)


def fault_task(plant: Plant) -> None:
    """The system calls the program of the fault tasks."""
    plant.interpreter.run("CutFault")


def mend(plant: Plant) -> None:
    """What was broken is whole again; errors remain to be acknowledged."""
    plant.closed.clear()
    plant.loose.clear()
    plant.broken.clear()
    plant.creeps.clear()
    plant.stop = False
    plant.frozen.clear()
    plant.astray.clear()
