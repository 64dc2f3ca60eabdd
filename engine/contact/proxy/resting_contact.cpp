#include "engine/contact/proxy/resting_contact.h"

#include <algorithm>

namespace springdrive::contact {

namespace {

void set_touched_point(const SurfacePoint &touched, Contact &contact) noexcept {
    contact.surface_m = touched.point_m;
    contact.barycentric = touched.barycentric;
    contact.triangle = touched.triangle;
    contact.material = touched.material;
}

} // namespace

Contact free_contact(const Vector3 &point_m) noexcept {
    Contact contact;
    contact.x0_m = point_m;
    return contact;
}

Contact resting_contact(const HapticSurface &surface, const Vector3 &tip_m,
                        const Rest &rest) noexcept {
    const AllowedMotion motion = tangent_projector(rest.held_by);
    const ContactPlane &first = rest.held_by[0];
    const Vector3 gap = rest.point_m - tip_m;
    const double gap_m = gap.norm();
    Contact contact;
    contact.touching = true;
    contact.x0_m = rest.point_m;
    contact.tangent_projector = motion.projector;
    contact.normal = gap_m > kLostByRoundOff_m ? Vector3(gap / gap_m) : first.normal;
    contact.active_constraints = motion.blocked_directions;
    for (const ContactPlane &plane : rest.held_by) {
        contact.eta = std::min(contact.eta, surface.material(plane.obstacle).eta);
    }
    set_touched_point(surface.nearest(first.obstacle, rest.point_m), contact);
    return contact;
}

Contact resting_contact(const HapticSurface &surface, std::uint32_t shape_obstacle,
                        const ShapeSlide &slide, double reach_m) noexcept {
    Contact contact;
    contact.touching = true;
    contact.x0_m = slide.rest_m;
    contact.tangent_projector -= slide.normal * slide.normal.transpose();
    contact.normal = slide.normal;
    contact.active_constraints = 1;
    contact.eta = surface.material(shape_obstacle).eta;
    set_touched_point(surface.point_on_shape(shape_obstacle, slide.rest_m - reach_m * slide.normal),
                      contact);
    return contact;
}

} // namespace springdrive::contact
