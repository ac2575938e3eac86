"""MJCF of a scene of one room, for tests of the command line."""

ROOM = """
<mujoco model="room">
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="right" type="box" size="0.05 1.6 0.5" pos="2.05 0 0.5"/>
    <geom name="left" type="box" size="0.05 1.6 0.5" pos="-2.05 0 0.5"/>
    <geom name="up" type="box" size="2.1 0.05 0.5" pos="0 1.55 0.5"/>
    <geom name="down" type="box" size="2.1 0.05 0.5" pos="0 -1.55 0.5"/>
    {sites}
  </worldbody>
  <custom><numeric name="twonav.map" data="-2.4 -1.6 2.4 1.6"/></custom>
</mujoco>
"""
TWO_GOALS = '<site name="goal/east" pos="1.4 0.2 0"/><site name="goal/west" pos="-1.4 0.2 0"/>'
