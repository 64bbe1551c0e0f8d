// Bullet in double precision: a btRigidBody, stepSimulation(h, 0). Argument: the gyroscopic term, `default` (the flags that a
// new body has), `none`, `explicit`, `implicit-body` or `implicit-world`. See piped.py for the numbers.
#include <btBulletDynamicsCommon.h>
#include <cstdio>
#include <map>
#include <string>

int main(int, char **argument) {
    const std::map<std::string, int> flags = {{"none", 0}, {"explicit", BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT},
        {"implicit-body", BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY}, {"implicit-world", BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD}};
    double h, mass, J[3], q[4], w[3], x[3], u[3];
    while (std::scanf("%lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &h, &mass, J, J + 1, J + 2, q, q + 1,
                      q + 2, q + 3, w, w + 1, w + 2, x, x + 1, x + 2, u, u + 1, u + 2) == 18) {
        btDefaultCollisionConfiguration configuration;
        btCollisionDispatcher dispatcher(&configuration);
        btDbvtBroadphase broadphase;
        btSequentialImpulseConstraintSolver solver;
        btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
        world.setGravity(btVector3(0, 0, 0));
        btSphereShape shape(0.1);
        btRigidBody body(mass, nullptr, &shape, btVector3(J[0], J[1], J[2]));
        body.setCenterOfMassTransform(btTransform(btQuaternion(q[1], q[2], q[3], q[0]), btVector3(x[0], x[1], x[2])));
        body.setLinearVelocity(btVector3(u[0], u[1], u[2]));
        body.setAngularVelocity(btVector3(w[0], w[1], w[2]));
        body.setActivationState(DISABLE_DEACTIVATION);
        if (flags.count(argument[1])) body.setFlags(flags.at(argument[1]));
        world.addRigidBody(&body);
        world.stepSimulation(h, 0);
        const btQuaternion r = body.getOrientation();
        const btVector3 a = body.getAngularVelocity(), p = body.getCenterOfMassPosition(), v = body.getLinearVelocity();
        std::printf("%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\n", r.w(), r.x(), r.y(), r.z(),
                    a.x(), a.y(), a.z(), p.x(), p.y(), p.z(), v.x(), v.y(), v.z());
        std::fflush(stdout);
        world.removeRigidBody(&body);
    }
}
