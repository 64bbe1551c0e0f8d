//! Rapier in double precision: a body without colliders, `PhysicsWorld::step`. Argument: `gyroscopic` (the default of a new body) or
//! `none`. A step has four substeps, the default. See `piped.py` for the numbers.
use rapier3d_f64::prelude::*;
use std::io::BufRead;

fn main() {
    let gyroscopic = std::env::args().nth(1).is_none_or(|mode| mode == "gyroscopic");
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let n: Vec<f64> = line.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        let vector = |k: usize| Vector::new(n[k], n[k + 1], n[k + 2]);
        let mut world = PhysicsWorld::new();
        world.gravity = Vector::ZERO;
        world.integration_parameters.dt = n[0];
        let attitude = Rotation::from_xyzw(n[6], n[7], n[8], n[5]);
        let body = RigidBodyBuilder::dynamic()
            .pose(Pose::from_parts(vector(12), attitude))
            .angvel(vector(9))
            .linvel(vector(15))
            .additional_mass_properties(MassProperties::new(Vector::ZERO, n[1], vector(2)))
            .gyroscopic_forces_enabled(gyroscopic)
            .can_sleep(false);
        let handle = world.insert_body(body);
        world.step();
        let body = &world.bodies[handle];
        let (q, w, x, u) = (body.rotation(), body.angvel(), body.translation(), body.linvel());
        let after = [q.w, q.x, q.y, q.z, w.x, w.y, w.z, x.x, x.y, x.z, u.x, u.y, u.z];
        println!("{}", after.map(|x| x.to_string()).join(" "));
    }
}
