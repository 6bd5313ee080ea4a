"""Estimators that are watched: a choice of their user, and what `pen_mhe.estimate` does itself."""

from __future__ import annotations

from typing import Any

from estimation.estimator import Estimator
from estimation.settings import config_of
from estimation.watch.config import WatchConfig
from estimation.watch.watched import Watched
from models.errors import InputError

WATCH = "the watch"


def watched(estimator: Estimator[Any], **settings: Any) -> Watched:
    """Return an estimator that is watched; itself an estimator, of the same name.

    Every reading is tested against what it was predicted to be. A sensor that is stuck, or not to
    be believed, is left out and taken back; what is not known any more is said, and started again
    from the prior. Statuses say it (`estimation.status.Status`), and ``flagged`` of whom::

        estimator = pm.watched(pm.create_estimator("ekf", model), on_lost="hold")
        history = pm.run(estimator, recording)

    Parameters
    ----------
    estimator : any, of a model of one's own too
    settings : of `estimation.watch.config.WatchConfig`, by keyword

    Raises
    ------
    InputError
        If a watch does not read a setting, or a value is not allowed.
    """
    return Watched(estimator, config_of(WATCH, {WATCH: WatchConfig}, settings))


def as_asked(
    estimator: Estimator[Any], watch: bool | None, smooth: bool, on_lost: str | None
) -> Estimator[Any]:
    """Return an estimator, watched or as it is.

    Parameters
    ----------
    watch : whether it is watched; None watches unless it is smoothed
    smooth : whether somebody goes back over its estimates, which then have to be its model's
    on_lost : see `estimation.watch.config.WatchConfig`; None takes the default

    Raises
    ------
    InputError
        If what is asked for makes no sense together.
    """
    if watch and smooth:
        raise InputError(
            "a run is watched and smooth, expected one: smoothing goes back over a model's own "
            "steps, and a watch leaves out sensors and starts again"
        )
    is_watched = not smooth if watch is None else watch
    if is_watched:
        return watched(estimator, **({} if on_lost is None else {"on_lost": on_lost}))
    if on_lost is not None:
        raise InputError(
            f"on_lost is {on_lost!r} of a run that is not watched, expected a run that is watched"
        )
    return estimator
