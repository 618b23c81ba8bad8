"""What the head camera sees of scenario (a): everything that matters, at the right depth."""

from collections.abc import Iterator

import mujoco
import numpy as np
import pytest

from support.pictures import decoded
from w2c.depth import decode_depth
from w2c.errors import ConfigError
from w2c.geometry import Intrinsics
from w2c.messages import Array, PictureRequest
from w2c_sim_robot.camera import gl, renderer
from w2c_sim_robot.camera.culling import may_be_seen
from w2c_sim_robot.camera.measure import measure
from w2c_sim_robot.camera.renderer import Renderer
from w2c_sim_robot.camera.studio import Studio
from w2c_sim_robot.model import HEAD_CAMERA, HEAD_SHELL_GROUP, ready_configuration
from w2c_sim_robot.scenes.scenario_a import scenario_a

VISIBLE_GROUPS = np.array([1, 1, 0, 0, 0, 0], np.uint8)


@pytest.fixture(scope="module")
def studio() -> Iterator[Studio]:
    """Yield the model of scenario (a) with the robot standing ready."""
    made = Studio(scenario_a())
    made.pose(ready_configuration(made.model))
    yield made
    made.close()


@pytest.fixture(scope="module")
def body_seen(studio: Studio) -> Array:
    """Return (h, w): the id of the body that each pixel of the head camera shows, -1 for none."""
    geoms = studio.renderer.segment(
        studio.data, HEAD_CAMERA, size=(1280, 720), hidden_groups=(HEAD_SHELL_GROUP,)
    )
    return np.append(studio.model.geom_bodyid, -1)[geoms]


@pytest.mark.parametrize(("name", "pixels"), [("book", 20_000), ("cup", 3_000), ("table", 200_000)])
def test_what_the_scenario_needs_is_in_view(
    studio: Studio, body_seen: Array, name: str, pixels: int
) -> None:
    seen = body_seen == studio.model.body(name).id

    assert seen.sum() > pixels
    # The cup is wholly in the picture.
    if name == "cup":
        rows, columns = np.nonzero(seen)
        assert rows.min() > 5
        assert 5 < columns.min() < columns.max() < 1275


def test_left_is_left_and_far_is_up(studio: Studio, body_seen: Array) -> None:
    def middle(name: str) -> Array:
        rows, columns = np.nonzero(body_seen == studio.model.body(name).id)
        return np.array([columns.mean(), rows.mean()])

    assert middle("cup")[0] < middle("book")[0]
    assert middle("cup")[1] < middle("book")[1]


def test_the_heads_own_shell_does_not_hide_the_view(body_seen: Array, studio: Studio) -> None:
    head = {studio.model.body(name).id for name in ("head_1_link", "head_2_link")}

    assert not np.isin(body_seen, list(head)).any()


def test_depth_is_what_a_ray_measures(studio: Studio, body_seen: Array) -> None:
    frame = studio.frame(5)
    depth = decode_depth(frame.depth, frame.width, frame.height, frame.depth_unit)
    intrinsics = Intrinsics(*frame.intrinsics)
    camera = studio.data.camera(HEAD_CAMERA)
    world_from_optical = camera.xmat.reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(400):
        u, v = int(rng.integers(1280)), int(rng.integers(720))
        ray = world_from_optical @ intrinsics.point_from_pixel(u + 0.5, v + 0.5, 1.0)
        length = float(np.linalg.norm(ray))
        geom = np.array([-1], np.int32)
        distance = mujoco.mj_ray(
            studio.model, studio.data, camera.xpos, ray / length, VISIBLE_GROUPS, 1, -1, geom
        )
        if geom[0] >= 0 and studio.model.geom_bodyid[geom[0]] == body_seen[v, u]:
            errors.append(abs(distance / length - depth[v, u]))

    assert len(errors) > 350
    assert np.percentile(errors, 99) < 0.0005
    assert frame.stamp_ns == 5


def test_a_pretty_frame_has_the_same_size_and_the_same_depth(studio: Studio) -> None:
    plain, pretty = studio.frame(1), studio.frame(1, shadows=True, antialiasing=True)
    first = decode_depth(plain.depth, 1280, 720)
    second = decode_depth(pretty.depth, 1280, 720)

    assert decoded(pretty.jpeg).shape == (720, 1280, 3)
    assert pretty.jpeg != plain.jpeg
    # Half a pixel of a tilted table, and other surfaces at edges only.
    assert np.median(np.abs(first - second)) < 0.001
    assert np.mean(np.abs(first - second) > 0.01) < 0.02


@pytest.mark.parametrize("view", ["side", "front", "over_shoulder"])
def test_pictures_from_outside_show_the_robot(studio: Studio, view: str) -> None:
    request = PictureRequest(view=view, width=320, height=240)  # type: ignore[arg-type]

    picture = studio.picture(7, request)

    image = decoded(picture.jpeg)
    assert image.shape == (240, 320, 3)
    assert image.std() > 25
    geoms = studio.renderer.segment(studio.data, view, size=(320, 240))
    bodies = np.append(studio.model.geom_bodyid, -1)[geoms]
    assert (bodies == studio.model.body("torso_2_link").id).sum() > 300
    assert (bodies == studio.model.body("table").id).sum() > 300


def test_another_scene_than_the_robots_is_noticed(studio: Studio) -> None:
    with pytest.raises(ConfigError, match="same --scene"):
        studio.pose(np.zeros(studio.model.nq + 7))


def test_a_picture_larger_than_the_renderer_is_refused(studio: Studio) -> None:
    with pytest.raises(ConfigError, match="4000x100"):
        studio.renderer.draw(studio.data, HEAD_CAMERA, size=(4000, 100))


@pytest.mark.parametrize("size", [(0, 0), (16, 0), (-4, 16)])
def test_a_picture_without_pixels_is_refused(studio: Studio, size: tuple[int, int]) -> None:
    with pytest.raises(ConfigError, match=f"{size[0]}x{size[1]} px; ask for 1x1 px or more"):
        studio.renderer.draw(studio.data, HEAD_CAMERA, size=size)
    with pytest.raises(ConfigError, match=f"camera of {size[0]}x{size[1]} px"):
        Renderer(studio.model, *size)


def test_one_channel_alone_is_that_of_both(studio: Studio) -> None:
    both = studio.shoot()
    colours, depth = studio.shoot(depth=False), studio.shoot(colours=False)

    assert np.array_equal(colours.rgb, both.rgb) and not colours.depth.size
    assert np.array_equal(depth.depth, both.depth) and not depth.rgb.size
    assert studio.frame(1, depth=False).depth == b""


def test_a_survey_gives_depth_of_the_surface_that_it_names(studio: Studio) -> None:
    geoms, depth = studio.renderer.survey(
        studio.data, HEAD_CAMERA, size=(320, 180), hidden_groups=(HEAD_SHELL_GROUP,)
    )

    assert (depth[geoms >= 0] > 0.1).all()


def test_costs_of_a_picture_are_measured_case_by_case() -> None:
    costs = measure((64, 64), count=1, seed=0, warm_up=0)

    assert [cost.case for cost in costs] == ["rgb", "depth", "rgbd", "rgbd_pretty"]
    assert all(cost.cpu_ms > 0 and cost.bytes > 100 for cost in costs)
    assert costs[2].bytes > costs[0].bytes


def test_a_machine_without_opengl_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "nonsense")

    with pytest.raises(ConfigError, match=r"MUJOCO_GL=nonsense.*apt-get install -y libegl1"):
        gl.choose_backend()


@pytest.mark.parametrize("camera", [HEAD_CAMERA, "side"])
def test_what_is_left_out_of_a_picture_was_not_in_it(
    studio: Studio, monkeypatch: pytest.MonkeyPatch, camera: str
) -> None:
    def draw() -> tuple[Array, Array]:
        hidden = (HEAD_SHELL_GROUP,) if camera == HEAD_CAMERA else ()
        image = studio.renderer.draw(studio.data, camera, size=(320, 180), hidden_groups=hidden)
        return image.rgb, image.depth

    groups = studio.model.geom_group.copy()
    seen = may_be_seen(studio.model, studio.data, studio.model.camera(camera).id, 320 / 180)
    colours, depth = draw()
    monkeypatch.setattr(renderer, "may_be_seen", lambda *_: None)
    all_colours, all_depth = draw()

    assert np.array_equal(colours, all_colours)
    assert np.array_equal(depth, all_depth)
    assert np.array_equal(studio.model.geom_group, groups)
    if camera == HEAD_CAMERA:
        assert (~seen).sum() > 30, "most of the robot is behind its eyes"


def test_metric_depth_is_as_exact_as_its_steps(studio: Studio) -> None:
    extent = studio.model.stat.extent
    near, far = (extent * one for one in (studio.model.vis.map.znear, studio.model.vis.map.zfar))
    z = np.linspace(0.3, 16.0, 1000)
    buffer = ((near / z - near / far) / (1.0 - near / far)).astype(np.float32)

    metric = studio.renderer._metric(np.append(buffer, np.float32(0.0)))

    assert metric[:-1] == pytest.approx(z, rel=2e-5)
    assert metric[-1] == 0.0
