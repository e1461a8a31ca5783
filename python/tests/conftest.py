import signal

import numpy as np
import pytest
import shotline

# A shell ignores interrupts for what it starts in the background, but some tests interrupt themselves.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


@pytest.fixture(scope="session")
def sample_scene():
    """A scene with combinations, shared nodes, groups, materials and two objects."""
    drill = shotline.Cylinder(radius=0.4, z0=-2, z1=2)
    block = shotline.Box(min=(-2, -2, -1), max=(2, 2, 1)) - drill - drill.translate(1.2, 0, 0)
    ring = shotline.Torus(R=1.0, r=0.3)
    rings = shotline.Group(ring.translate(0, 0, 2), ring.rotate(30, 0, 10).translate(0, 0, 3.5))
    return shotline.Scene(
        block.named("block", material="steel"),
        shotline.Group(rings, rings.translate(5, 0, 0)).named("rings", material="brass"),
        materials={"steel": shotline.Material(mu=2.0, density=7.8), "brass": {"mu": 3.0}},
        units="cm",
    )


@pytest.fixture(scope="session")
def sample_rays():
    """Origins and directions of rays through the sample scene, (500, 3) each."""
    random = np.random.default_rng(6)
    o = random.normal(size=(500, 3)) * 8
    return o, random.uniform([-2, -2, -1], [6, 2, 4], (500, 3)) - o
