"""Playing a stream as over a line: what has arrived after so many seconds. The operator needs a window: window_preview."""
import bpy
import pytest

from .conftest import refusal


@pytest.fixture
def clock(part, monkeypatch):
    """Seconds that the test sets."""
    now = [100.0]
    monkeypatch.setattr(part("preview.playback").time, "monotonic", lambda: now[0])
    return now


def test_what_has_arrived_is_what_the_line_carried(part, previewed, clock):
    playback, progressive = part("preview.playback"), part("preview").progressive_of(previewed)
    state = previewed.npmesh
    state.play_rate = 8  # 1000 bytes a second
    play = playback.start(previewed)
    seen = []
    for _ in range(200):
        clock[0] += 0.05
        going = play.step(previewed)
        assert state.features == (progressive.features_for(max(play.arrived, progressive.base_bytes)) if going else play.features)
        assert play.arrived == min(int(1000 * (clock[0] - 100)), play.end)
        seen.append(state.features)
        if not going:
            break
    assert seen == sorted(seen) and len(set(seen)) > 3
    assert state.features == state.arrived_features and play.elapsed == pytest.approx(play.end / 1000)
    assert play.fraction == 1


def test_it_ends_at_the_features_that_were_set(part, previewed, clock):
    previewed.npmesh.features = 30
    play = part("preview.playback").start(previewed)
    clock[0] += 1000
    assert not play.step(previewed) and previewed.npmesh.features == 30
    assert play.end == part("preview").progressive_of(previewed).bytes_for(30)


def test_stopping_gives_the_features_back(part, previewed, clock):
    playback = part("preview.playback")
    previewed.npmesh.features = 30
    playback.start(previewed).step(previewed)
    assert previewed.npmesh.features == 0 and playback.is_playing(previewed)
    bpy.ops.object.npmesh_stop_playing()
    assert previewed.npmesh.features == 30 and not playback.is_playing(previewed)


def test_saving_ends_playing_first(part, previewed, clock, tmp_path):
    part("preview.playback").start(previewed).step(previewed)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"), check_existing=False)
    assert previewed.npmesh.features == previewed.npmesh.total_features
    assert not part("preview.playback").is_playing(previewed)


def test_without_a_window_it_says_so(previewed):
    assert "Expected a window to play in, found none" in refusal(bpy.ops.object.npmesh_play)
