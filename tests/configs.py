"""The config of one estimator, of settings that a test gives to several."""

from __future__ import annotations

from typing import Any

from pen_mhe.estimators import ESTIMATORS, settings_read


def config_for(estimator: Any, **settings: Any) -> Any:
    """Return an estimator's config with what it reads of the settings.

    Parameters
    ----------
    estimator : its name, or its class
    """
    name = estimator if isinstance(estimator, str) else estimator.name
    return ESTIMATORS[name].config(**settings_read(name, settings))
