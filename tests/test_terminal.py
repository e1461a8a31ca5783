"""What a terminal shows, and a file does not."""

import fcntl
import json
import os
import pty
import struct
import subprocess
import termios

from command import SHOTLINE, run

SPHERE = '{"shotline": 1, "objects": [{"name": "a", "node": {"kind": "spere", "radius": 1}}]}'


def on_a_terminal(*arguments, **environment):
    """What a command writes on a terminal as its standard error."""
    return _shown(arguments, lambda slave: {"stderr": slave, "env": os.environ | environment})


def _shown(arguments, options):
    """What a command writes on a terminal, which `options` gives to it."""
    master, slave = pty.openpty()
    process = subprocess.Popen([SHOTLINE, *map(str, arguments)], **options(slave))
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


def shown_in(columns, *arguments):
    """What a command writes to a terminal of this many columns as its standard output."""

    def options(slave):
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        return {"stdout": slave, "stderr": subprocess.DEVNULL}

    return _shown(arguments, options)


def test_tables_fit_the_terminal(tmp_path):
    name = "a part with a name of many words"
    ball = {"name": name, "material": "steel", "node": {"kind": "sphere", "radius": 1}}
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps({"shotline": 1, "units": "mm", "materials": {"steel": {}}, "objects": [ball]}))
    shoot = ["shoot", scene, "--from=-3,0.1,0.2", "--dir=1,0,0"]
    for command in [shoot, ["measure", scene]]:
        piped = run(*command).stdout
        assert max(map(len, piped.splitlines())) > 90 and name in piped
        assert shown_in(400, *command) == piped
        for columns in (80, 72):
            shown = shown_in(columns, *command)
            assert max(map(len, shown.splitlines())) <= columns, shown
            # Words may be on several lines, but none is lost.
            assert set(piped.split()) == set(shown.split())
    narrow = shown_in(40, "info", scene)
    table = narrow[narrow.index("  object") :]
    assert max(map(len, table.splitlines())) <= 40 and "steel" in table
