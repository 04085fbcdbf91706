"""The server of a live page: who may move the robot, what is told, what is dropped, and that nothing is left behind."""

import asyncio
import gc
import http.client
import json
import logging
import threading
import time
import urllib.request
from urllib.parse import urlsplit

import numpy as np
import pytest
from tornado.websocket import websocket_connect

import robust_ik as rik
from robust_ik.display import LiveView, view
from robust_ik.display.scene.live_server import LONGEST_MESSAGE
from robust_ik.errors import InputError

SECONDS = 60


@pytest.fixture(scope="module")
def known():
    robot = rik.load("planar_3r")
    return robot, rik.find_singularities(robot, starts=200, certify=False)


@pytest.fixture
def page(known):
    with view(known[0], atlas=known[1]) as page:
        yield page


def talk(page, messages, until):
    """The first told message for which `until` is true, after sending messages."""

    async def run():
        text, connection = "", await websocket_connect(f"ws://{urlsplit(page.url).netloc}/control?token={page.token}")
        try:
            for message in messages:
                text = message if isinstance(message, (str, bytes)) else json.dumps(message)
                connection.write_message(text, binary=isinstance(text, bytes))
            while True:
                text = await asyncio.wait_for(connection.read_message(), SECONDS)
                assert text is not None, "the connection was closed"
                if until(told := json.loads(text)):
                    return told
        finally:
            connection.close()
            while text is not None:
                text = await asyncio.wait_for(connection.read_message(), SECONDS)

    return asyncio.run(run())


def answer_to(page, token=None, **headers):
    """The status with which the server answers a page that wants to move the robot."""
    address = urlsplit(page.url)
    token = page.token if token is None else token
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=SECONDS)
    wanted = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
    try:
        key = {"Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA=="}
        connection.request("GET", f"/control?token={token}", headers={**wanted, **key, **headers})
        with connection.getresponse() as answer:
            return answer.status
    finally:
        connection.close()


def test_who_has_the_token_moves_the_robot_and_is_told_where_it_is(page):
    told = talk(page, [{"do": "joint", "index": 1, "value": 0.25}], lambda told: told.get("values", [0, 0])[1] == 0.25)
    assert told["said"] == ""
    assert page.q[1] == 0.25
    assert np.allclose(told["sigma"], rik.svd(page.robot.jacobian(page.q)).s)


def test_families_are_told_with_the_nearest_one(page):
    told = talk(page, [], lambda told: told["kind"] == "families" and told["searched"] == 1.0)
    assert [each["words"] for each in told["families"]]
    told = talk(page, [{"do": "family", "index": 0}], is_on_the_first_family)
    assert told["nearby"]["words"] == page.atlas.strata[0].words


def is_on_the_first_family(told):
    return told["kind"] == "state" and told["nearby"] is not None and told["nearby"]["distance"] < 1e-6


@pytest.mark.parametrize("token", ["", "wrong", "%00", "x" * 5000])
def test_without_the_token_nothing_moves(page, token):
    assert answer_to(page, token) == 403
    assert answer_to(page) == 101
    plain = page.url.split("?", maxsplit=1)[0]
    with urllib.request.urlopen(plain, timeout=SECONDS) as answer:
        text = answer.read().decode()
    assert page.token not in text
    assert "slide" not in text.split("<script", maxsplit=1)[0]


@pytest.mark.parametrize("headers", [{"Origin": "http://evil.example"}, {"Host": "evil.example"}])
def test_pages_of_others_are_refused_even_with_the_token(page, headers):
    assert answer_to(page, **headers) in (403, 404)


def test_each_run_has_a_token_of_its_own(known):
    with view(known[0], atlas=known[1]) as one, view(known[0], atlas=known[1]) as two:
        assert one.token != two.token
        assert len(one.token) >= 32


def test_what_is_no_command_is_dropped_with_a_line_in_the_log(page, caplog):
    with caplog.at_level(logging.WARNING):
        told = talk(
            page,
            ["nonsense", b"\xff", '{"do": "explode"}', {"do": "joint", "index": 0, "value": 0.125}],
            lambda told: told.get("values", [0])[0] == 0.125,
        )
    assert told["values"][0] == 0.125
    dropped = [record.message for record in caplog.records if "dropped" in record.message]
    assert len(dropped) == 3
    assert all("\n" not in line and len(line) < 400 for line in dropped)


def test_a_huge_message_ends_its_connection_and_no_other(page):
    with pytest.raises(AssertionError, match="closed"):
        talk(page, ["x" * (LONGEST_MESSAGE + 1)], lambda told: False)
    talk(page, [{"do": "rest"}], lambda told: told["kind"] == "state")


def test_a_flood_of_commands_ends_with_the_last_one(page):
    messages = [{"do": "joint", "index": 0, "value": value / 2000} for value in range(2001)]
    told = talk(page, messages, lambda told: told.get("values", [0])[0] == 1.0)
    assert told["values"][0] == 1.0


def test_python_moves_what_pages_show(page):
    q = np.array(page.robot.rest) + 0.1
    page.show(q)
    told = talk(page, [], lambda told: told["kind"] == "state" and np.allclose(told["q"], q))
    assert np.allclose(told["q"], q)


def test_nothing_is_left_when_it_is_closed(known):
    before = {thread.name for thread in threading.enumerate()}
    page = view(known[0], atlas=known[1])
    url = page.url
    talk(page, [], lambda told: True)
    page.close()
    page.close()
    gc.collect()
    assert {thread.name for thread in threading.enumerate()} <= before
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(url, timeout=SECONDS)
    assert "closed" in repr(page)
    assert "closed" in page._repr_html_()


def test_the_search_for_families_ends_with_the_page():
    page = view(rik.load("kinova_gen3"))
    time.sleep(0.3)
    page.close()
    ends = [thread for thread in threading.enumerate() if thread.name.startswith("robust_ik.")]
    for thread in ends:  # what is being compiled is compiled first
        thread.join(2 * SECONDS)
    assert not any(thread.is_alive() for thread in ends)
    assert page.atlas is None


def test_names_from_files_are_text_in_the_page(tmp_path):
    hostile = "<script>alert(1)</script>"
    links = "".join(f'<link name="l{k}"/>' for k in range(3))
    joints = "".join(
        f'<joint name="{hostile.replace("<", "&lt;")}{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>'
        '<origin xyz="1 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        for k in range(2)
    )
    path = tmp_path / "hostile.urdf"
    path.write_text(f'<robot name="{hostile.replace("<", "&lt;")}">{links}{joints}</robot>')
    with view(rik.load(path)) as page:
        with urllib.request.urlopen(page.url, timeout=SECONDS) as answer:
            text = answer.read().decode()
        assert hostile not in text
        assert "alert(1)" in text


def test_bad_arguments_are_refused_and_leave_nothing(known):
    robot = known[0]
    for options in ({"port": -1}, {"q": [0.0]}, {"q": [np.nan] * robot.nq}, {"port": "80"}):
        with pytest.raises(InputError):
            view(robot, **options)
    assert not any(thread.name.startswith("robust_ik.") for thread in threading.enumerate())
    with view(robot, atlas=known[1]) as page, pytest.raises(OSError, match="in use"):
        view(robot, port=urlsplit(page.url).port)
    assert isinstance(page, LiveView)
