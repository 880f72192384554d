// The planetary ring of cases/shear/planetary-ring.toml in REBOUND (Rein and Liu 2012), without gravity between the
// particles. Prints one line per orbit: the orbits, the mean squares [m^2/s^2] of the velocities along x (vertical), y
// (radial) and z (along the orbit) in the axes of the case, the kinetic and collisional viscosities [m^2/s] of that
// orbit, and the collisions per particle and orbit.
//
// Build in a folder with REBOUND (hannorein/rebound@6c44115f) beside it:
//   make -C rebound/src && cc -O3 -Irebound/src ring.c -o ring -Lrebound/src -lrebound -lm -Wl,-rpath,rebound/src
//   ./ring ORBITS STEP SEED        the step is in orbits; its example takes 1e-3
#include "rebound.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double OMEGA = 1.3143527e-4, EDGE = 40.0, RADIUS = 0.5;
static const int COUNT = 1019;

static double bridges(const struct reb_simulation* const r, double v) {
    (void)r;
    double e = pow(fabs(v) / 0.0768e-3, -0.234);
    return e > 1.0 ? 1.0 : e;
}

int main(int argc, char** argv) {
    double orbits = argc > 1 ? atof(argv[1]) : 20, step = argc > 2 ? atof(argv[2]) : 1e-3;
    struct reb_simulation* r = reb_simulation_create();
    r->rand_seed = argc > 3 ? atoi(argv[3]) : 1;
    reb_simulation_set_integrator(r, "sei");
    r->boundary = REB_BOUNDARY_SHEAR;
    r->gravity = REB_GRAVITY_NONE;
    r->collision = REB_COLLISION_TREE;
    r->collision_resolve = reb_collision_resolve_hardsphere;
    r->coefficient_of_restitution = bridges;
    r->OMEGA = OMEGA;
    r->dt = step * 2.0 * M_PI / OMEGA;
    r->minimum_collision_velocity = RADIUS * OMEGA * 0.001;
    r->root_size = EDGE;
    r->N_ghost_x = 1;
    r->N_ghost_y = 1;
    double mass = 900.0 * 4.0 / 3.0 * M_PI * pow(RADIUS, 3);
    for (int i = 0; i < COUNT; i++) {
        struct reb_particle p = {0};
        p.x = reb_random_uniform(r, -EDGE / 2, EDGE / 2);
        p.y = reb_random_uniform(r, -EDGE / 2, EDGE / 2);
        p.z = reb_random_normal(r, 1.0);
        p.vx = reb_random_normal(r, pow(0.15e-3, 2));
        p.vy = -1.5 * p.x * OMEGA;
        p.m = mass;
        p.r = RADIUS;
        reb_simulation_add(r, p);
    }
    double period = 2.0 * M_PI / OMEGA;
    for (int orbit = 1; orbit <= orbits; orbit++) {
        double sums[4] = {0};
        int samples = 0;
        r->collisions_plog = 0;
        r->collisions_log_n = 0;
        for (int k = 1; k <= 50; k++) {
            reb_simulation_integrate(r, (orbit - 1 + k / 50.0) * period);
            for (int i = 0; i < r->N; i++) {
                struct reb_particle p = r->particles[i];
                double along = p.vy + 1.5 * OMEGA * p.x;
                double add[4] = {p.vz * p.vz, p.vx * p.vx, along * along, p.vx * along};
                for (int s = 0; s < 4; s++) sums[s] += add[s] / r->N;
            }
            samples++;
        }
        printf("%d %.5e %.5e %.5e %.5e %.5e %.4f\n", orbit, sums[0] / samples, sums[1] / samples, sums[2] / samples,
               2.0 / 3.0 / OMEGA * sums[3] / samples,
               2.0 / 3.0 / OMEGA / (COUNT * mass) / period * r->collisions_plog,
               2.0 * r->collisions_log_n / COUNT);
        fflush(stdout);
    }
    reb_simulation_free(r);
    return 0;
}
