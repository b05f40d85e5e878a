"""Motion curves, and the kernel that moves the tools by them."""

import math
from typing import NamedTuple

import numpy as np
import pytest
import warp as wp
from hypothesis import given, settings
from hypothesis import strategies as st

from weavesim.errors import InputError
from weavesim.kernels.rows import ClockEntry, ToolDriveRow, ToolWatchRow, ToolWorkRow
from weavesim.kernels.stepping.tools import ToolBooks, tool_motion_kernel
from weavesim.process.strokes import Fixed, ForceDriven, SmoothStroke, Stroke
from weavesim.tools.device import build_device_tools
from weavesim.tools.shapes import Plane
from weavesim.tools.tool import Tool


class Tools(NamedTuple):
    """What the kernel writes, in its order."""

    displacement: wp.array
    velocity: wp.array
    force: wp.array
    drive: wp.array
    books: ToolBooks

    @property
    def work(self) -> wp.array:
        return self.books.work

    @property
    def watch(self) -> wp.array:
        return self.books.watch


def run(tools, step: float, step_count: int, reaction=(0.0, 0.0, 0.0), stiffness=()):
    """Displacement and velocity after each step, (step_count, tool_count), and all that the kernel wrote."""
    device = build_device_tools(tools, wp.float64, "cpu", stiffness=stiffness)
    clock = np.zeros(ClockEntry.row_count())
    clock[ClockEntry.step] = clock[ClockEntry.mean_step] = step
    clock = wp.array(clock, dtype=wp.float64, device="cpu")
    # each tool feels the reaction in two blocks
    half = np.tile(0.5 * np.array(reaction), (len(tools), 2, 1))
    reactions = wp.array(half, dtype=wp.vec3d, device="cpu")
    books = ToolBooks()
    books.work = wp.zeros((ToolWorkRow.row_count(), len(tools)), dtype=wp.float64, device="cpu")
    books.watch = wp.zeros((ToolWatchRow.row_count(), len(tools)), dtype=wp.float64, device="cpu")
    state = Tools(
        wp.array(device.initial_displacement, dtype=wp.float64, device="cpu"),
        wp.array(device.initial_velocity, dtype=wp.float64, device="cpu"),
        wp.zeros(len(tools), dtype=wp.vec3d, device="cpu"),
        wp.zeros((ToolDriveRow.row_count(), len(tools)), dtype=wp.float64, device="cpu"),
        books,
    )
    displacement, velocity = [], []
    for _ in range(step_count):
        wp.launch(
            tool_motion_kernel(wp.float64, device.waits),
            dim=1,
            inputs=[device.drives, reactions],
            outputs=[clock, *state],
            device="cpu",
        )
        displacement.append(state.displacement.numpy().copy())
        velocity.append(state.velocity.numpy().copy())
    return np.array(displacement), np.array(velocity), state


def tool(motion, axis=(0.0, 0.0, -1.0)):
    return Tool("tool", Plane(), motion, axis=axis)


@settings(max_examples=50, deadline=None)
@given(
    st.floats(0.001, 0.2),
    st.floats(0.01, 5.0),
    st.just(0.0) | st.floats(1e-4, 0.5),
    st.floats(0.0, 0.1),
    st.booleans(),
)
def test_smooth_stroke_goes_all_the_way_never_faster_than_asked(distance, speed, ramp_time, start_time, backwards):
    signed = -distance if backwards else distance
    stroke = Stroke.smooth(signed, speed, ramp_time, start_time)
    times, travel = stroke.curve()
    ramp = min(ramp_time, distance / speed)
    assert stroke.duration == pytest.approx(start_time + distance / speed + ramp)
    assert travel[0] == 0.0 and travel[-1] == pytest.approx(signed)
    velocity = np.diff(travel) / np.diff(times)
    assert np.all(np.sign(signed) * velocity >= -1e-6 * speed)
    assert np.abs(velocity).max() <= speed * (1 + 1e-6)
    if ramp_time > 0.0:
        assert np.abs(np.diff(velocity)).max() < 0.01 * speed
        assert max(abs(velocity[0]), abs(velocity[-1])) < 0.01 * speed


def test_smooth_stroke_keeps_its_speed_between_the_ramps():
    stroke = Stroke.smooth(0.06, 2.0, 0.01, 0.003)
    at = np.linspace(0.013, 0.033, 50)
    np.testing.assert_allclose(np.interp(at, *stroke.curve()), 0.01 + 2.0 * (at - 0.013), atol=1e-12)
    # half of the ramp time is lost on each ramp, by symmetry a quarter of the travel lies behind its middle
    assert np.interp(0.008, *stroke.curve()) == pytest.approx(2.0 * 0.01 * (0.5**3 - 0.5**5))


@settings(max_examples=20, deadline=None)
@given(st.lists(st.tuples(st.floats(0.001, 0.02), st.floats(-0.1, 0.1)), min_size=1, max_size=8))
def test_stroke_kernel_interpolates_like_numpy(knots):
    times = np.cumsum([gap for gap, _ in knots]) - 0.01
    stroke = Stroke(tuple(times), tuple(value for _, value in knots))
    others = (tool(Fixed()), tool(Stroke.smooth(0.06, 1.0, 0.01)))
    displacement, velocity, state = run([others[0], tool(stroke), others[1]], 1e-3, 80)
    at = 1e-3 * np.arange(1, 81)
    for k, motion in ((0, Fixed()), (1, stroke), (2, others[1].motion)):
        expected = np.interp(at, *motion.curve())
        np.testing.assert_allclose(displacement[:, k], expected, atol=1e-15)
        before = np.interp(at - 1e-3, *motion.curve())
        np.testing.assert_allclose(velocity[:, k], (expected - before) / 1e-3, atol=1e-10)
    start = build_device_tools([tool(stroke)], wp.float64, "cpu").initial_displacement
    assert start[0] == pytest.approx(np.interp(0.0, *stroke.curve()))
    assert len(state.displacement) == 3


def test_driven_tool_falls_as_newton_says():
    mass, force, along, step, count = 2.0, 100.0, -30.0, 1e-4, 500
    axis = np.array([0.6, 0.0, -0.8])
    reaction = along * axis + 7.0 * np.array([0.8, 0.0, 0.6])  # the sideways part does nothing
    displacement, velocity, state = run([tool(ForceDriven.constant(force, mass), axis)], step, count, reaction)
    acceleration = (force + along) / mass
    n = np.arange(1, count + 1)
    np.testing.assert_allclose(velocity[:, 0], acceleration * n * step, rtol=1e-12)
    np.testing.assert_allclose(displacement[:, 0], acceleration * step**2 * n * (n + 1) / 2, rtol=1e-10)
    np.testing.assert_allclose(state.force.numpy()[0], reaction, atol=1e-12)
    # half of the step before and half of the one to come; the last half is still to come
    travel = step * (velocity[:, 0].sum() - 0.5 * velocity[-1, 0])
    on_sheet, driving, damping, carrying = state.work.numpy()[:, 0]
    assert damping == 0.0  # nobody said how stiff the contact is
    np.testing.assert_allclose([on_sheet, driving], [-along * travel, force * travel], rtol=1e-12)
    assert driving - on_sheet == pytest.approx(0.5 * mass * velocity[-1, 0] ** 2, rel=1e-12)


def test_driven_force_follows_its_curve():
    motion = ForceDriven.constant(10.0, 4.0, ramp_time=0.02)
    _, velocity, _ = run([tool(motion)], 1e-4, 400)
    # momentum is the force's integral: half of the ramp, then all
    assert 4.0 * velocity[199, 0] == pytest.approx(0.5 * 10.0 * 0.02, rel=0.01)
    assert 4.0 * (velocity[399, 0] - velocity[199, 0]) == pytest.approx(10.0 * 0.02, rel=0.01)


@pytest.mark.parametrize("real", [wp.float32, wp.float64], ids=["float32", "float64"])
def test_device_arrays_hold_what_the_tools_say(real):
    punch = Tool(
        "punch", Plane(origin=(0.1, 0.2, 0.3)), Stroke((0.0, 0.5), (0.01, 0.06)), friction=0.3, axis=(0, 0, -2)
    )
    holder = Tool("blank_holder", Plane(), ForceDriven((0.0,), (50.0,), 3.0), friction=0.1)
    device = build_device_tools([punch, holder], real, "cpu")
    record = device.tool.numpy()
    np.testing.assert_allclose(record["friction"], [0.3, 0.1], rtol=1e-6)
    np.testing.assert_array_equal(record["first_part"], [0, 1])
    np.testing.assert_array_equal(record["axis"], [[0, 0, -1], [0, 0, 1]])
    np.testing.assert_allclose(device.part.numpy()["origin"][0], [0.1, 0.2, 0.3], rtol=1e-6)
    np.testing.assert_array_equal(device.drives.drive.numpy()["mass"], [0.0, 3.0])
    np.testing.assert_allclose(device.initial_displacement, [0.01, 0.0])
    np.testing.assert_allclose(device.initial_velocity, [0.1, 0.0])


def test_no_tools_make_empty_arrays():
    device = build_device_tools([], wp.float32, "cpu")
    assert device.count == 0
    assert device.part.shape == device.drives.drive.shape == device.initial_displacement.shape == (0,)


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: Stroke((), ()), "at least one"),
        (lambda: Stroke((0.0, 1.0), (0.0,)), "2 times and 1 displacements"),
        (lambda: Stroke((0.0, 0.0), (0.0, 1.0)), "must increase"),
        (lambda: Stroke((0.0, math.nan), (0.0, 1.0)), "Stroke: times = .*: entry 1 = nan: a finite number is needed"),
        (lambda: Stroke(0.0, 1.0), "list of numbers"),
        (lambda: Stroke.smooth(0.0, 1.0, 0.1), "Fixed"),
        (lambda: Stroke.smooth(0.1, -1.0, 0.1), "speed"),
        (lambda: Stroke.smooth(0.1, 1.0, -0.1), "must not be negative"),
        (lambda: ForceDriven((0.0,), (1.0,), 0.0), "ForceDriven: mass = 0.0"),
        (lambda: Tool("punch", Plane(), "down"), "one of Fixed, Stroke, ForceDriven"),
        (lambda: Tool("punch", Plane(), SmoothStroke((0.0,), (0.0,), (0.0,))), "of Fixed, Stroke, ForceDriven"),
        (lambda: Tool("punch", "round"), "shape"),
        (lambda: Tool("punch", Plane(), friction=-0.1), "friction"),
        (lambda: Tool("punch", Plane(), axis=(0, 0, 0)), "axis"),
        (lambda: Tool("punch", Plane(), colour=(0, 0, 2)), "colour"),
    ],
)
def test_bad_motions_and_tools_are_refused(build, says):
    with pytest.raises(InputError, match=says):
        build()


def test_the_force_of_every_step_is_watched():
    """0.6 of what is wanted is carried; a tool that is moved by a stroke wants nothing."""
    driven = ForceDriven.constant(10.0, 1.0)
    _, _, state = run([tool(driven), tool(Fixed())], 1e-4, 50, reaction=(0.0, 8.0, 6.0))
    watch = dict(zip(ToolWatchRow.names(), state.watch.numpy(), strict=True))
    assert watch["peak"].tolist() == [10.0, 10.0]
    assert watch["most_wanted"].tolist() == [10.0, 0.0]
    assert watch["wanted"] == pytest.approx([5e-3, 0.0]) and watch["idle"].tolist() == [0.0, 0.0]
    assert watch["carried_impulse"][0] == pytest.approx(0.6 * watch["wanted_impulse"][0]) == pytest.approx(0.03)
    _, _, state = run([tool(driven)], 1e-4, 50, reaction=(0.0, 0.0, 4.9))
    assert state.watch.numpy()[ToolWatchRow.idle, 0] == pytest.approx(5e-3)


def test_a_damper_slows_a_tool_that_carries_and_fades():
    """Carrying exactly its force, a tool loses its speed to the damper: v' = -c/m exp(-t/T) v, all of it booked."""
    force, mass, stiffness, step = 10.0, 2.0, 8.0e4, 1e-5
    motion = ForceDriven.constant(force, mass, damping_ratio=0.05)
    damping, fading = motion.damper(stiffness)
    assert damping == pytest.approx(0.1 * math.sqrt(stiffness * mass)) and fading == pytest.approx(20.0)
    tools, device = [tool(motion)], build_device_tools([tool(motion)], wp.float64, "cpu", stiffness=[stiffness])
    assert device.drives.drive.numpy()["damping"][0] == pytest.approx(damping)
    _, velocity, _ = run(tools, step, 2000, (0.0, 0.0, 0.0), [stiffness])
    # in the air it is free
    np.testing.assert_allclose(velocity[:, 0], force / mass * step * np.arange(1, 2001), rtol=1e-12)
    _, velocity, state = run(tools, step, 2000, (0.0, 0.0, 0.5 * force), [stiffness])
    time = step * np.arange(1, 2001)
    rate = damping / mass
    # v' = F/2m - rate exp(-fading t) v, by quadrature of the exact solution
    decay = rate / fading * (1.0 - np.exp(-fading * time))
    whole = np.concatenate([[0.0], np.cumsum(step * np.exp(decay))])[1:]
    expected = 0.5 * force / mass * np.exp(-decay) * whole
    np.testing.assert_allclose(velocity[:, 0], expected, rtol=2e-3)
    booked = dict(zip(ToolWorkRow.names(), state.work.numpy()[:, 0], strict=True))
    kinetic = 0.5 * mass * velocity[-1, 0] ** 2
    assert booked["driving"] - booked["on_sheet"] - booked["damping"] == pytest.approx(kinetic, rel=1e-3)
    assert state.drive.numpy()[ToolDriveRow.carrying, 0] == pytest.approx(time[-1])


def test_a_stroke_with_a_largest_force_waits_and_backs_off():
    """At full speed below 0.8 of it, at rest at it, backwards above: a stroke that is on time without a force."""
    motion = Stroke((-1.0, 1.0), (-1.0, 1.0), largest_force=10.0)
    axis = (0.0, 0.0, -1.0)

    def speed(push: float) -> tuple[float, float]:
        displacement, velocity, _ = run([tool(motion, axis)], 1e-3, 200, (0.0, 0.0, push), [1.0])
        return float(velocity[-1, 0]), float(displacement[-1, 0])

    assert speed(0.0) == pytest.approx((1.0, 0.2)) == speed(7.9) == speed(-50.0)
    assert speed(9.0)[0] == pytest.approx(0.5)
    assert speed(10.0) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert speed(11.0)[0] == pytest.approx(-0.5)
    # a stiff contact lowers the gain: what is left halves from step to step
    _, velocity, _ = run([tool(motion, axis)], 1e-3, 1, (0.0, 0.0, 9.0), [1.0e6])
    assert velocity[0, 0] * 1e-3 * 1.0e6 == pytest.approx(0.5 * (10.0 - 9.0))


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_spacers_stop_a_tool_and_take_its_energy(direction):
    """A mass that falls for 5 mm stands there; what the force did is what the spacers took."""
    mass, force, step, stop = 2.0, 100.0, 1e-4, 0.005
    motion = ForceDriven.constant(direction * force, mass, stop=direction * stop)
    displacement, velocity, state = run([tool(motion)], step, 400)
    assert direction * displacement[-1, 0] == pytest.approx(stop, abs=1e-15) and velocity[-1, 0] == 0.0
    assert (direction * displacement).max() <= stop + 1e-15
    on_sheet, driving, damping, carrying = state.work.numpy()[:, 0]
    # the velocity runs half a step ahead of the place
    assert driving == pytest.approx(force * stop, rel=0.02) and damping == pytest.approx(driving, rel=1e-12)
    assert on_sheet == carrying == 0.0
    # a force is not wanted of the sheets while spacers carry it
    watched = state.watch.numpy()
    assert watched[ToolWatchRow.waited, 0] == pytest.approx(np.sqrt(2.0 * stop * mass / force), rel=0.02)


def test_a_tool_beyond_its_spacers_is_held_where_it_is():
    displacement, velocity, _ = run([tool(ForceDriven.constant(100.0, 2.0, stop=-0.001))], 1e-4, 50)
    assert not displacement.any() and not velocity.any()
