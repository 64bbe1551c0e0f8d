// cannon-es: a free body with three different moments of inertia keeps its angular velocity in space, so its momentum turns.
import { Body, Vec3, World } from "cannon-es";

const J = [0.6, 1.0, 1.3], w = [0.9, -0.5, 0.7];
for (const n of [100, 1000, 10000]) {
  const world = new World({ gravity: new Vec3(0, 0, 0) });
  const body = new Body({ mass: 1, linearDamping: 0, angularDamping: 0 });
  world.addBody(body);
  body.inertia.set(...J);
  body.invInertia.set(...J.map((x) => 1 / x));
  body.angularVelocity.set(...w);
  body.updateInertiaWorld(true);
  const momentum = () => {
    const local = body.quaternion.inverse().vmult(body.angularVelocity);
    return body.quaternion.vmult(new Vec3(local.x * J[0], local.y * J[1], local.z * J[2]));
  };
  const before = momentum();
  for (let k = 0; k < n; k++) world.step(1 / n);
  console.log(n, "steps: angular velocity", body.angularVelocity.toString(), "change of the momentum in space", momentum().vsub(before).toString());
}
