"""Mazes and simulators as Gymnasium environments: the one place that imports gymnasium. Importing it registers them."""

from twonav_cli.environments.registration import register

register()
