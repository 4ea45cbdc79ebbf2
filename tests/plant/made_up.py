"""Made-up descriptions with all that readers look at, to be damaged."""

_FRAME = """<?xml version="1.0"?>
<sdf version="1.9">
  <model name="frame">
    <frame name="mount" attached_to="body"><pose degrees="true">0 0 0.02 0 0 90</pose></frame>
    <link name="body">
      <inertial><pose>0 0 0.01 0 0 0</pose><mass>1.2</mass>
        <inertia><ixx>0.01</ixx><iyy>0.012</iyy><izz>0.02</izz></inertia></inertial>
      <visual name="v"><geometry><box><size>0.2 0.2 0.05</size></box></geometry></visual>
      <collision name="c"><geometry><cylinder><radius>0.1</radius><length>0.05</length>
        </cylinder></geometry></collision>
      <sensor name="imu" type="imu"><update_rate>200</update_rate><imu><angular_velocity><x>
        <noise type="gaussian"><stddev>0.001</stddev></noise></x></angular_velocity></imu></sensor>
      <sensor name="scan" type="gpu_lidar"><pose relative_to="mount">0 0 0.1 0 0 0</pose>
        <update_rate>10</update_rate><lidar><scan><horizontal><samples>360</samples>
        <min_angle>-3.1</min_angle><max_angle>3.1</max_angle></horizontal></scan>
        <range><min>0.1</min><max>30</max></range></lidar></sensor>
    </link>
    <model name="gimbal"><link name="camera"><pose>0.1 0 0 0 0 0</pose></link></model>
    <joint name="pan" type="revolute"><parent>body</parent><child>gimbal::camera</child>
      <axis><xyz expressed_in="__model__">0 0 1</xyz></axis></joint>
    {rotors}
  </model>
</sdf>"""
_ROTOR = """
    <link name="r{i}"><pose relative_to="mount">{x} {y} 0.03 0 0 0</pose>
      <inertial><mass>0.01</mass><inertia><ixx>1e-6</ixx><iyy>1e-5</iyy><izz>1e-5</izz></inertia>
      </inertial></link>
    <joint name="j{i}" type="continuous"><parent>body</parent><child>r{i}</child>
      <axis><xyz>0 0 1</xyz></axis></joint>
    <plugin filename="gz-sim-multicopter-motor-model-system" name="m{i}">
      <jointName>j{i}</jointName><linkName>r{i}</linkName><motorNumber>{i}</motorNumber>
      <turningDirection>{turn}</turningDirection><motorConstant>1e-5</motorConstant>
      <momentConstant>0.02</momentConstant><maxRotVelocity>1000</maxRotVelocity>
      <timeConstantUp>0.02</timeConstantUp><timeConstantDown>0.03</timeConstantDown></plugin>"""
MJCF = """<mujoco model="frame"><compiler angle="radian"/>
  <default><geom density="300"/><default class="r"><motor ctrlrange="0 6"/></default></default>
  <asset><mesh name="m" file="gone.obj" scale="1 1 1"/><material name="c" rgba="1 0 0 1"/></asset>
  <worldbody><body name="hull"><freejoint/>
    <geom name="box" type="box" size="0.1 0.1 0.02" euler="0 0 0.1"/>
    <geom type="capsule" size="0.01" fromto="0 0 0 0.2 0.2 0"/>
    <geom type="mesh" mesh="m" mass="0.1" material="c" contype="0" conaffinity="0"/>
    <frame pos="0 0 0.01" quat="1 0 0 0"><site name="s0" pos="0.2 0.2 0"/></frame>
    <site name="s1" pos="-0.2 0.2 0"/><site name="s2" pos="-0.2 -0.2 0" zaxis="0 0 1"/>
    <site name="s3" pos="0.2 -0.2 0" axisangle="0 0 1 1"/>
    <body name="mast" pos="0 0 0.1" xyaxes="1 0 0 0 1 0"><joint name="pan" axis="0 0 1"/>
      <inertial pos="0 0 0.01" mass="0.1" fullinertia="1e-4 1e-4 1e-4 0 0 0"/></body>
  </body></worldbody>
  <actuator><motor class="r" name="a" site="s0" gear="0 0 1 0 0 -0.02"/>
    <motor class="r" name="b" site="s1" gear="0 0 1 0 0 0.02"/>
    <general class="r" name="c" site="s2" gear="0 0 1 0 0 -0.02" ctrlrange="0 6" dyntype="filter"
      dynprm="0.02" gainprm="1 0"/>
    <motor class="r" name="d" site="s3" gear="0 0 1 0 0 0.02"/></actuator>
</mujoco>"""
_PLACES = ((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2))
SDF = _FRAME.format(
    rotors="".join(
        _ROTOR.format(i=i, x=x, y=y, turn=("cw", "ccw")[i % 2]) for i, (x, y) in enumerate(_PLACES)
    )
)
