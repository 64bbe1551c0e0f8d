// The Open Dynamics Engine: a body without geometry, dWorldStep or dWorldQuickStep. Arguments: `step` or `quick`, and the gyroscopic
// mode, `gyroscopic` (the default of the library) or `none`. See piped.py for the numbers.
#include <cstdio>
#include <cstring>
#include <ode/ode.h>

static_assert(sizeof(dReal) == 8, "a library in double precision");

int main(int, char **argument) {
    const bool quick = !std::strcmp(argument[1], "quick");
    dInitODE();
    double h, mass, J[3], q[4], w[3], x[3], u[3];
    while (std::scanf("%lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &h, &mass, J, J + 1, J + 2, q, q + 1,
                      q + 2, q + 3, w, w + 1, w + 2, x, x + 1, x + 2, u, u + 1, u + 2) == 18) {
        if (h <= 0) {  // an assertion of the library
            std::puts("");
            std::fflush(stdout);
            continue;
        }
        dWorldID world = dWorldCreate();
        dBodyID body = dBodyCreate(world);
        dMass inertia;
        dMassSetParameters(&inertia, mass, 0, 0, 0, J[0], J[1], J[2], 0, 0, 0);
        dBodySetMass(body, &inertia);
        dBodySetGyroscopicMode(body, !std::strcmp(argument[2], "gyroscopic"));
        dBodySetQuaternion(body, q);
        dBodySetPosition(body, x[0], x[1], x[2]);
        dBodySetLinearVel(body, u[0], u[1], u[2]);
        dBodySetAngularVel(body, w[0], w[1], w[2]);
        if (quick) dWorldQuickStep(world, h); else dWorldStep(world, h);
        const dReal *p[] = {dBodyGetQuaternion(body), dBodyGetAngularVel(body), dBodyGetPosition(body), dBodyGetLinearVel(body)};
        for (int k = 0; k < 4; ++k)
            for (int i = 0; i < (k ? 3 : 4); ++i) std::printf("%.17g ", p[k][i]);
        std::puts("");
        std::fflush(stdout);
        dWorldDestroy(world);
    }
}
