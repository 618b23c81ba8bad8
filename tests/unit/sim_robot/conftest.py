"""Tests that draw need OpenGL without a display: choose how before MuJoCo is imported."""

from w2c_sim_robot.camera.gl import choose_backend

choose_backend()
