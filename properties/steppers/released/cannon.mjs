// cannon-es: a Body in a World, World.step(h). See piped.py for the numbers.
import readline from "node:readline";
import { Body, Vec3, World } from "cannon-es";

for await (const line of readline.createInterface({ input: process.stdin })) {
  const [h, mass, a, b, c, ...n] = line.trim().split(/\s+/).map(Number);
  const world = new World({ gravity: new Vec3(0, 0, 0) });
  const body = new Body({ mass, linearDamping: 0, angularDamping: 0 });
  world.addBody(body);
  body.inertia.set(a, b, c);
  body.invInertia.set(1 / a, 1 / b, 1 / c);
  body.quaternion.set(n[1], n[2], n[3], n[0]);
  body.angularVelocity.set(n[4], n[5], n[6]);
  body.position.set(n[7], n[8], n[9]);
  body.velocity.set(n[10], n[11], n[12]);
  body.updateInertiaWorld(true);
  world.step(h);
  const { quaternion: q, angularVelocity: w, position: x, velocity: u } = body;
  console.log([q.w, q.x, q.y, q.z, w.x, w.y, w.z, x.x, x.y, x.z, u.x, u.y, u.z].join(" "));
}
