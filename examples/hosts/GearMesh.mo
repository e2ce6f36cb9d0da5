within;
model GearMesh "An external gear pair on fixed axes: mesh stiffness over the angle of gear 1, damping, backlash"
  import Modelica.Units.SI;
  parameter String file "Table by python -m examples.hosts.mesh_stiffness PAIR.json TORQUE TABLE.txt";
  parameter SI.Length baseRadius1 "Of gear 1";
  parameter SI.Length baseRadius2 "Of gear 2";
  parameter SI.TranslationalDampingConstant damping = 0 "On the line of action";
  parameter SI.Length backlash = 0 "Normal, between the flanks";
  parameter SI.Force fullDamping = 1 "Force from which on the damping acts in full";
  Modelica.Mechanics.Rotational.Interfaces.Flange_a gear1;
  Modelica.Mechanics.Rotational.Interfaces.Flange_b gear2 "Turns against gear 1";
  Modelica.Blocks.Tables.CombiTable1Ds stiffness(
    tableOnFile=true,
    tableName="stiffness",
    fileName=file,
    columns={2},
    smoothness=Modelica.Blocks.Types.Smoothness.ContinuousDerivative,
    extrapolation=Modelica.Blocks.Types.Extrapolation.Periodic);
  SI.Length approach "On the line of action, > 0 with the drive flanks in contact";
  SI.Velocity rate "Of the approach";
  SI.Force elastic "> 0 on the drive flanks";
  SI.Force force "With damping; teeth never pull";
equation
  approach = baseRadius1*gear1.phi + baseRadius2*gear2.phi;
  rate = der(approach);
  stiffness.u = gear1.phi;
  elastic = stiffness.y[1]*(if approach > 0 then approach elseif approach < -backlash then approach + backlash else 0);
  force = if elastic > 0 then max(0, elastic + damping*min(1, elastic/fullDamping)*rate) else min(0, elastic + damping*min(1, -elastic/fullDamping)*rate);
  gear1.tau = baseRadius1*force;
  gear2.tau = baseRadius2*force;
end GearMesh;
