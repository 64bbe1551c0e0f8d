#!/usr/bin/env python3
"""DART: a skeleton with one free joint, World.step."""
from body import serve

import dartpy as dart
import numpy as np


def step(b):
    world, skeleton = dart.simulation.World(), dart.dynamics.Skeleton()
    joint, node = skeleton.createFreeJointAndBodyNodePair()
    node.setInertia(dart.dynamics.Inertia(b.mass, b.center, b.J))
    world.setGravity(np.zeros(3))
    world.setTimeStep(b.h)
    world.addSkeleton(skeleton)
    place = dart.math.Isometry3()
    place.set_rotation(b.R)
    place.set_translation(b.p)
    joint.setTransform(place)
    joint.setRelativeSpatialVelocity(np.concatenate([b.w, b.v]))  # in the body frame, angular part first
    node.addExtTorque(b.torque, True)  # in the body frame
    node.addExtForce(b.force, np.zeros(3), True, True)
    world.step()
    place, velocity = node.getWorldTransform(), node.getSpatialVelocity()
    return place.rotation(), place.translation(), velocity[:3], velocity[3:]


serve(step)
