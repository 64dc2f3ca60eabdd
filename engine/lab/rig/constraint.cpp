#include "engine/lab/rig/constraint.h"

#include "engine/contact/proxy/proxy.h"

namespace springdrive::rig {

Constraint free_space() {
    return [](const Vector3 &tip_m) {
        contact::Contact contact;
        contact.x0_m = tip_m;
        return contact;
    };
}

Constraint tied_to(const Vector3 &point_m) {
    contact::Contact contact;
    contact.touching = true;
    contact.x0_m = point_m;
    contact.tangent_projector.setZero();
    contact.eta = 0.0;
    return [contact](const Vector3 &) { return contact; };
}

Constraint plane(const Vector3 &point_m, const Vector3 &normal, Sides sides) {
    return [point_m, normal, sides](const Vector3 &tip_m) {
        contact::Contact contact;
        const double outside_m = normal.dot(tip_m - point_m);
        if (sides == Sides::one && outside_m >= 0.0) {
            contact.x0_m = tip_m;
            return contact;
        }
        contact.touching = true;
        contact.x0_m = tip_m - outside_m * normal;
        contact.tangent_projector = Matrix3::Identity() - normal * normal.transpose();
        contact.normal = normal;
        contact.eta = 0.0;
        contact.active_constraints = 1;
        return contact;
    };
}

Constraint surface(const contact::HapticSurface &surface) {
    return [&surface, proxy = contact::Proxy(), starts = true](const Vector3 &tip_m) mutable {
        if (starts) {
            proxy.reset(tip_m);
            starts = false;
        }
        return proxy.update(surface, tip_m);
    };
}

} // namespace springdrive::rig
