"""A model of one's own on both estimators: the damped spring of CasADi's MHE example.

There the MHE does worse than a Kalman filter (casadi issue 4226). On a linear model
the two must agree, and here they do. (The known force of that example changes no
estimation error of a linear model and is left out.)
"""

import casadi as ca
import numpy as np

import pen_mhe as pm

MASS, STIFFNESS, DAMPING, DISTURBANCE = 1.0, 1.0, 0.5, 0.1


def transition(x, w, dt):
    """One Runge-Kutta step under a disturbance that is constant during the step."""

    def rate(x):
        return ca.vertcat(x[1], (-STIFFNESS * x[0] - DAMPING * x[1]) / MASS + DISTURBANCE * w[0])

    k1 = rate(x)
    k2 = rate(x + dt / 2 * k1)
    k3 = rate(x + dt / 2 * k2)
    k4 = rate(x + dt * k3)
    return x + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


states = {"position_m": (1.0, 0.01), "velocity_m_s": (0.0, 0.01)}
ruler = pm.OwnSensor(lambda x: x[0], axes={"x": "m"}, noise_std=0.005, rate_hz=20.0)
model = pm.own_model("damped spring", states, transition, n_noises=1, sensors={"ruler": ruler})
recording = pm.simulate_model(model, duration_s=50.0, seed=0)
for name in pm.LEAST_SQUARES:
    history = pm.run(pm.create_estimator(name, model), recording)
    errors = pm.state_errors(model, history, recording.truth)
    print(name, "RMS position, velocity:", np.sqrt((errors**2).mean(axis=0)))
