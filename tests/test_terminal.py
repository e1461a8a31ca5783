"""What a terminal shows, and a file does not."""

import json
import os
import pty
import subprocess

from command import SHOTLINE, run

SPHERE = '{"shotline": 1, "objects": [{"name": "a", "node": {"kind": "spere", "radius": 1}}]}'


def on_a_terminal(*arguments, **environment):
    """What a command writes on a terminal as its standard error."""
    master, slave = pty.openpty()
    process = subprocess.Popen([SHOTLINE, *map(str, arguments)], stderr=slave, env=os.environ | environment)
    os.close(slave)
    shown = b""
    try:
        while part := os.read(master, 4096):
            shown += part
    except OSError:
        pass  # the other end is closed
    process.wait(timeout=30)
    os.close(master)
    return shown.decode().replace("\r\n", "\n")


def test_errors_have_colours_on_a_terminal_alone(tmp_path):
    scene = tmp_path / "scene.json"
    scene.write_text(SPHERE)
    plain = run("info", scene).stderr
    assert plain.startswith("error: ") and "\x1b" not in plain and "sphere" in plain
    shown = on_a_terminal("info", scene, TERM="xterm-256color")
    assert shown.startswith("\x1b[1m\x1b[31merror:\x1b[0m ")
    assert on_a_terminal("info", scene, TERM="xterm-256color", NO_COLOR="1") == plain


def test_names_send_nothing_to_a_terminal(tmp_path):
    name = "a\x1b[31m"
    nodes = [{"kind": "box", "min": [i, 0, 0], "max": [i + 2, 2, 2]} for i in range(2)]
    scene = tmp_path / "scene.json"
    scene.write_text(
        json.dumps({"shotline": 1, "objects": [{"name": f"{name}{i}", "node": nodes[i]} for i in range(2)]})
    )
    ray = ["--from=-1,1,1", "--dir=1,0,0"]
    commands = [["shoot", scene, *ray], ["check", scene], ["info", scene], ["measure", scene]]
    for command in [*commands, ["slice", scene, "--plane", "z=1", "-o", tmp_path / "out.svg"]]:
        told = run(*command)
        assert "\x1b" not in told.stdout + told.stderr, command
        assert command[0] == "measure" or "a\ufffd[31m" in told.stdout + told.stderr, command
