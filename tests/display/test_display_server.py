import asyncio
import gc
import ipaddress
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from tornado.httpclient import HTTPClientError, HTTPRequest
from tornado.websocket import websocket_connect

from robust_ik.display import Scene, serve
from robust_ik.display.scene import live_server
from robust_ik.display.scene.meshcat_module import geometry, umsgpack

SECONDS = 60


@pytest.fixture
def scene():
    with serve() as scene:
        yield scene


def get(url, **headers):
    with urllib.request.urlopen(urllib.request.Request(url, headers=headers), timeout=SECONDS) as answer:
        return answer.status, answer.read().decode()


def watch(scene, count, change=None, **headers):
    """The first `count` commands that a browser gets, `change` being made once it is connected and has one."""

    async def run():
        request = HTTPRequest(scene.url.replace("http", "ws"), headers=headers, request_timeout=SECONDS)
        connection = await websocket_connect(request)
        try:
            messages = []
            while len(messages) < count:
                messages.append(umsgpack.unpackb(await asyncio.wait_for(connection.read_message(), SECONDS)))
                if change is not None and len(messages) == 1:
                    change()
            return messages
        finally:
            connection.close()
            await connection.read_message()

    return asyncio.run(run())


def listening_addresses():
    """Local addresses of this process's listening sockets, from the kernel's own tables."""
    own = set()
    for link in Path("/proc/self/fd").iterdir():
        try:
            own.add(str(link.readlink()))
        except OSError:
            continue
    found = []
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        for line in Path(table).read_text().splitlines()[1:] if Path(table).exists() else ():
            fields = line.split()
            if fields[3] == "0A" and f"socket:[{fields[9]}]" in own:
                host, port = fields[1].split(":")
                words = b"".join(bytes.fromhex(host[i : i + 8])[::-1] for i in range(0, len(host), 8))
                found.append((str(ipaddress.ip_address(words)), int(port, 16)))
    return found


def test_the_server_says_that_it_listens_on_loopback_only(scene):
    host, port = scene.server.address
    assert host == "127.0.0.1"
    assert scene.url == f"http://127.0.0.1:{port}/"


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="reads Linux's tables")
def test_the_kernel_says_so_too():
    before = set(listening_addresses())
    with serve() as scene:
        new = set(listening_addresses()) - before
        assert new == {("127.0.0.1", scene.server.address[1])}
    assert set(listening_addresses()) == before


def test_the_page_comes_with_the_viewer_and_may_talk_to_its_server_only(scene):
    status, page = get(scene.url)
    assert status == 200
    assert "MeshCat.Viewer" in page
    assert f'; connect-src ws://{scene.url[7:-1]}">' in page
    assert "main.min.js" in get(scene.url + "static/")[1]
    assert len(get(scene.url + "static/main.min.js")[1]) > 100_000


def test_a_browser_gets_the_whole_scene_and_then_every_change(scene):
    scene["box"].set_object(geometry.Box([1, 1, 1]))
    scene["box"].set_transform(np.eye(4))
    messages = watch(scene, 3, change=lambda: scene["box"].set_property("visible", False))
    assert [message["type"] for message in messages] == ["set_object", "set_transform", "set_property"]
    assert [message["type"] for message in watch(scene, 3)] == ["set_object", "set_property", "set_transform"]


@pytest.mark.parametrize("origin", ["http://example.org", "null", "http://127.0.0.1:1", "http://localhost.example.org"])
def test_a_page_from_elsewhere_may_not_listen(scene, origin):
    with pytest.raises(HTTPClientError, match="403"):
        watch(scene, 1, Origin=origin)


def test_a_page_of_the_server_may(scene):
    scene["a"].set_property("visible", True)
    assert watch(scene, 1, Origin=scene.url[:-1])


@pytest.mark.parametrize("host", ["example.org", "example.org:80", "127.0.0.1.example.org"])
def test_the_server_does_not_answer_to_a_foreign_name(scene, host):
    with pytest.raises(urllib.error.HTTPError, match="404"):
        get(scene.url, Host=host)


def test_no_file_outside_the_viewer_is_served(scene):
    for path in ("static/../__init__.py", "static/%2e%2e/%2e%2e/__init__.py", "static//etc/passwd", "etc/passwd"):
        with pytest.raises(urllib.error.HTTPError, match=r"40[34]"):
            get(scene.url + path)


def test_closing_frees_the_port_and_keeps_the_scene(tmp_path):
    scene = Scene.live()
    port = scene.server.address[1]
    scene["a"].set_property("visible", True)
    scene.close()
    scene.close()
    assert not scene.server.running
    scene["a"].set_property("visible", False)
    assert len(scene.commands) == 1
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", port))
    with Scene.live(port) as again:
        assert get(again.url)[0] == 200


def test_closing_disconnects_a_browser_that_watches():
    scene = serve()
    scene["a"].set_property("visible", True)

    async def run():
        connection = await websocket_connect(scene.url.replace("http", "ws"))
        await asyncio.wait_for(connection.read_message(), SECONDS)
        await asyncio.get_running_loop().run_in_executor(None, scene.close)
        last = await asyncio.wait_for(connection.read_message(), SECONDS)
        connection.close()
        return last

    assert asyncio.run(run()) is None


def test_a_port_that_is_taken_is_said_to_be(scene):
    with pytest.raises(OSError, match="in use"):
        serve(scene.server.address[1])


def test_a_notebook_shows_the_live_page_while_it_lives():
    with serve() as scene:
        assert f'src="{scene.url}"' in scene._repr_html_()
    assert "srcdoc" in scene._repr_html_()


def test_many_threads_may_draw(scene):
    def draw(name):
        for value in range(50):
            scene[name].set_property("visible", value % 2 == 0)

    threads = [threading.Thread(target=draw, args=(f"node{i}",)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(scene.commands) == 8
    assert len(watch(scene, 8)) == 8


@pytest.mark.skipif(os.name == "nt", reason="kills as Unix does")
@pytest.mark.parametrize("how", ["kill", "end"])
def test_the_server_ends_with_the_program_however_that_ends(how):
    code = "import sys; from robust_ik.display import serve; print(serve().url, flush=True); sys.stdin.read()"
    with subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as program:
        url = program.stdout.readline().strip()
        assert get(url)[0] == 200
        if how == "kill":
            program.send_signal(signal.SIGKILL)
        _, errors = program.communicate(timeout=SECONDS)
    assert errors == ""
    with pytest.raises(urllib.error.URLError, match="refused"):
        get(url)


# ------------------------------------------------------------------------------------------------ slow and gone
def upgraded(scene):
    """A browser's bare socket that has asked for the commands and reads none."""
    host, port = scene.server.address
    raw = socket.create_connection((host, port), timeout=SECONDS)
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.sendall(
        f"GET / HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    assert raw.recv(12) == b"HTTP/1.1 101"
    return raw


def flood(scene, count, size):
    for index in range(count):
        scene["box"].set_object(geometry.Box([1, 1, 1]))
        scene["box"].set_property("name", f"{index} " + "x" * size)


@contextmanager
def server_held(scene):
    """The server does nothing meanwhile."""
    held, go = threading.Event(), threading.Event()
    scene.server._loop.call_soon_threadsafe(lambda: (held.set(), go.wait(SECONDS)))
    held.wait(SECONDS)
    yield
    go.set()


def until(condition):
    """Waits for what another thread brings about; it fails by never coming true."""
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.fixture
def quiet(caplog, capfd):
    """Whatever happens, nothing is logged or printed."""
    yield
    gc.collect()  # what nobody waited for is told when it is collected
    assert caplog.get_records("call") + caplog.records == []
    assert capfd.readouterr() == ("", "")


def test_a_viewer_that_does_not_read_takes_bounded_memory_and_then_sees_the_scene_as_it_is(scene, quiet, monkeypatch):
    monkeypatch.setattr(live_server, "MOST_COMMANDS", 50)

    with upgraded(scene) as raw:
        until(lambda: len(scene.server._viewers) == 1)
        (viewer,) = scene.server._viewers
        for _ in range(20):
            flood(scene, 100, 10_000)
            until(lambda: scene.server._waiting.empty)
            assert len(viewer.queue._commands or ()) <= 50
        assert viewer.queue.size <= 50 * 11_000
        flood(scene, 1, 7)
        received = b""
        while b"0 xxxxxxx" not in received[-200_000:] or b"0 xxxxxxxx" in received[-60:]:
            received += raw.recv(65536)
    until(lambda: not scene.server._viewers)
    assert len(received) < 20_000_000


@pytest.mark.parametrize("how", ["says goodbye", "resets", "leaves in the midst of a message"])
def test_a_viewer_that_leaves_costs_nothing_and_says_nothing(scene, quiet, how):
    raws = [upgraded(scene) for _ in range(5)]
    until(lambda: len(scene.server._viewers) == 5)
    flood(scene, 200, 1000)
    for raw in raws:
        if how == "leaves in the midst of a message":
            raw.sendall(b"\x81\xfe\xff")
        elif how == "resets":
            raw.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        raw.close()
        if how != "says goodbye":
            flood(scene, 100, 1000)
    until(lambda: not scene.server._viewers and not scene.server._feeds)
    assert get(scene.url)[0] == 200


def test_a_server_ends_though_a_viewer_does_not_read(quiet):
    scene = serve()
    with upgraded(scene):
        until(lambda: len(scene.server._viewers) == 1)
        flood(scene, 300, 10_000)
        scene.close()
        assert not scene.server.running


def test_a_program_that_is_faster_than_the_server_is_not_held_up_and_nothing_piles_up(scene, quiet, monkeypatch):
    monkeypatch.setattr(live_server, "MOST_COMMANDS", 50)
    with server_held(scene):
        flood(scene, 500, 10)
        assert len(scene.server._waiting._commands or ()) <= 50
    assert [message["type"] for message in watch(scene, 2)] == ["set_object", "set_property"]


def test_a_viewer_that_fell_behind_is_cleared_before_it_gets_the_scene_anew(scene, monkeypatch):
    monkeypatch.setattr(live_server, "MOST_COMMANDS", 3)
    scene["gone"].set_property("visible", True)
    scene["box"].set_property("visible", True)

    def change():
        with server_held(scene):
            scene["gone"].delete()
            for value in range(10):
                scene["box"].set_property("visible", value % 2 == 0)

    messages = watch(scene, 4, change=change)
    assert [message["type"] for message in messages] == ["set_property", "set_property", "delete", "set_property"]
    assert messages[2]["path"] == "/meshcat"
    assert messages[3]["path"].endswith("box")
    assert messages[3]["value"] is False
