"""The server of `shotline view`: who gets what, and that no client harms another."""

import json
import os
import socket
import time
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest
from command import ROOT, run
from viewer import viewer

websocket = pytest.importorskip("websocket", reason="needs websocket-client")


@pytest.fixture(scope="module")
def server():
    with viewer(ROOT / "scenes" / "roth.json") as address:
        yield Server(address)


class Server:
    def __init__(self, address):
        parts = urlsplit(address)
        self.host, self.port, self.path = parts.netloc, parts.port, parts.path

    def raw(self, data, wait=8):
        """Sends bytes, and returns all that comes back."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=wait) as stream:
            stream.sendall(data)
            answer = b""
            try:
                while part := stream.recv(65536):
                    answer += part
            except TimeoutError:
                pass
            except ConnectionResetError:
                pass
            return answer

    def get(self, path, method="GET", **headers):
        lines = [f"{method} {path} HTTP/1.1"]
        lines += [f"{name.replace('_', '-')}: {value}" for name, value in ({"Host": self.host} | headers).items()]
        return self.raw("\r\n".join([*lines, "", ""]).encode())

    def socket(self, **options):
        options = {"origin": f"http://{self.host}"} | options
        return websocket.create_connection(f"ws://{self.host}{self.path}socket", timeout=20, **options)

    def ask(self, stream, question):
        stream.send(json.dumps({"id": 1} | question))
        return json.loads(stream.recv())

    def is_well(self):
        stream = self.socket()
        answer = self.ask(stream, {"ask": "scene"})
        stream.close()
        return answer["answer"]["name"] == "roth.json"


def status(answer):
    return int(answer.split(b" ", 2)[1])


def test_the_page_is_one_piece_and_loads_nothing_else(server):
    answer = server.get(server.path)
    head, body = answer.split(b"\r\n\r\n", 1)
    assert status(answer) == 200 and b"default-src 'none'" in head and b"no-store" in head
    assert f"Content-Length: {len(body)}".encode() in head
    for outside in (b"http://", b"https://", b'src="/', b"@import"):
        assert outside not in body, outside


def test_only_the_page_on_this_machine_is_answered(server):
    token = server.path.strip("/")
    assert len(token) == 32
    cases = [
        (404, server.get("/")),
        (404, server.get("/index.html")),
        (404, server.get(f"/{token[:-1]}x/")),
        (404, server.get(server.path + "../../etc/passwd")),
        (404, server.get(server.path + "scene.json")),
        (403, server.get(server.path, Host="evil.example")),
        (403, server.get(server.path, Host=f"evil.example:{server.port}")),
        (405, server.get(server.path, method="POST")),
        (400, server.get(server.path + "socket", Origin=f"http://{server.host}")),
        (403, server.get(server.path + "socket", Origin="http://evil.example")),
        (403, server.get(server.path + "socket")),
    ]
    assert [status(answer) for _, answer in cases] == [expected for expected, _ in cases]
    with pytest.raises(websocket.WebSocketBadStatusException):
        server.socket(origin="http://evil.example")
    # The server is bound to the loopback address alone.
    with open("/proc/net/tcp") as table:
        bound = [line.split()[1] for line in table if f":{server.port:04X} " in line.split()[1] + " "]
    assert bound and all(place.startswith("0100007F:") for place in bound)


def test_garbage_is_refused(server):
    for data in (
        b"\x16\x03\x01\x02\x00\x01\x00\x01" + bytes(200) + b"\r\n\r\n",
        b"GET\r\n\r\n",
        b"\r\n\r\n\r\n\r\n",
    ):
        assert status(server.raw(data)) == 400, data
    assert status(server.raw(b"GET / HTTP/1.1\r\nX: " + b"y" * 20_000)) == 431
    begun = time.monotonic()
    assert status(server.raw(b"GET / HTTP/1.1\r\n", wait=20)) == 408
    assert time.monotonic() - begun < 15
    assert server.is_well()


def test_questions_that_are_wrong_are_answered_in_words(server):
    stream = server.socket()
    picture = {
        "camera": {"eye": [5, 5, 5], "target": [0, 0, 0], "up": [0, 0, 1], "fov": 30},
        "size": [40, 30],
        "look": "lit",
        "shown": {},
    }
    draw = {"ask": "draw", "pane": 0, "picture": picture, "coarse": 1}
    wrong = [
        ("not understood", {"ask": "everything"}),
        ("not understood", {"ask": "draw"}),
        ("no look 'lid'", draw | {"picture": picture | {"look": "lid"}}),
        ("no accelerator 'fast'", draw | {"picture": picture | {"accel": "fast"}}),
        ("at most", draw | {"picture": picture | {"size": [100_000, 100_000]}}),
        ("at most", draw | {"picture": picture | {"size": [4096, 4096]}}),
        ("at most", draw | {"picture": picture | {"size": [0, 7]}}),
        ("no such pane", draw | {"pane": 7}),
        ("no object is named", draw | {"picture": picture | {"shown": {"only": ["nobody"]}}}),
        ("`eye`", draw | {"picture": picture | {"camera": picture["camera"] | {"eye": [0, 0, 0]}}}),
        ("not zero", {"ask": "shoot", "ray": {"origin": [0, 0, 0], "direction": [0, 0, 0]}}),
        ("no node", {"ask": "children", "of": 10**6, "from": 0}),
        ("normal", {"ask": "slice", "plane": [0, 0, 0, 1], "size": [9, 9], "by": "object"}),
    ]
    for words, question in wrong:
        assert words in server.ask(stream, question)["error"], question
    stream.send("{")
    assert "not understood" in json.loads(stream.recv())["error"]
    assert server.ask(stream, {"ask": "children", "from": 10**9})["answer"]["nodes"] == []
    stream.close()


def test_clients_that_break_the_rules_are_disconnected(server):
    for send in (
        lambda stream: stream.send(b"\x00" * 10, websocket.ABNF.OPCODE_BINARY),
        lambda stream: stream.send("x" * (2 << 20)),
        lambda stream: stream.sock.sendall(b"\xff" * 64),
    ):
        stream = server.socket()
        try:
            send(stream)
            for _ in range(5):
                if stream.recv() == "":
                    break
            ended = not stream.connected
        except (websocket.WebSocketException, OSError):
            ended = True
        assert ended
    assert server.is_well()


def test_a_client_that_reads_nothing_stops_no_other(server):
    stalled = server.socket()
    question = json.dumps(
        {
            "id": 1,
            "ask": "draw",
            "pane": 0,
            "coarse": 1,
            "picture": {
                "camera": {"eye": [5, 5, 5], "target": [0, 0, 0], "up": [0, 0, 1], "fov": 30},
                "size": [2000, 2000],
                "look": "normal",
                "shown": {},
            },
        }
    )
    stalled.settimeout(2)
    try:
        for _ in range(200):
            stalled.send(question)
    except (websocket.WebSocketException, OSError):
        pass
    assert server.is_well()
    stalled.close()


def test_there_are_few_connections_at_a_time(server):
    with ExitStack() as open_streams:
        for _ in range(16):
            stream = socket.create_connection(("127.0.0.1", server.port))
            open_streams.enter_context(stream)
        time.sleep(0.2)
        assert status(server.get(server.path)) == 503
    deadline = time.monotonic() + 40
    while status(server.get(server.path)) != 200:
        assert time.monotonic() < deadline
    # The pages of earlier tests may still be ending.
    pages = []
    while len(pages) < 4:
        try:
            pages.append(server.socket())
        except websocket.WebSocketBadStatusException:
            assert time.monotonic() < deadline
    with pytest.raises(websocket.WebSocketBadStatusException, match="503"):
        server.socket()
    for stream in pages:
        stream.close()
    while status(server.get(server.path)) != 200:
        assert time.monotonic() < deadline


def test_errors_of_the_command_name_what_is_wrong(tmp_path):
    assert "missing.json" in run("view", tmp_path / "missing.json", "--no-open").stderr
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        told = run("view", ROOT / "scenes" / "roth.json", "--no-open", "--port", port)
    assert told.returncode == 2 and f"127.0.0.1:{port}" in told.stderr and "--port" in told.stderr


def test_a_change_of_the_materials_that_a_mesh_names_is_seen(tmp_path):
    faces = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"
    (tmp_path / "part.obj").write_text(f"mtllib look.mtl\nusemtl paint\n{faces}")
    materials = tmp_path / "look.mtl"
    materials.write_text("newmtl paint\nKd 1 0 0\n")
    with viewer(tmp_path / "part.obj") as address:
        server = Server(address)
        stream = server.socket()

        def version():
            return server.ask(stream, {"ask": "scene"})["answer"]["version"]

        first = version()
        materials.write_text("newmtl paint\nKd 0 0 1\n")
        os.utime(materials, (1, 1))
        deadline = time.monotonic() + 20
        while version() == first:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        stream.close()
