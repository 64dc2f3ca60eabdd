// Vertex shader of scene, linkage and markers.
layout(location = 0) in vec3 position_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 vertex_colour; // linear
layout(location = 3) in vec2 texture_coordinate;
#ifdef TANGENTS
layout(location = 4) in vec4 tangent;
#endif

uniform mat4 model;
uniform mat3 normal_matrix;
uniform mat4 view_projection;
uniform mat4 light;  // from the world to the shadow maps
uniform vec4 colour; // linear

out vec3 world_position_m;
out vec3 world_normal;
out vec3 in_light;
out vec4 base_colour;
out vec2 base_coordinate;
#ifdef TANGENTS
out vec4 world_tangent; // and the bitangent's sign
#endif

void main() {
    vec4 world = model * vec4(position_m, 1.0);
    world_position_m = world.xyz;
    world_normal = normal_matrix * normal;
    in_light = (light * world).xyz;
    base_colour = colour * vertex_colour;
    base_coordinate = texture_coordinate;
#ifdef TANGENTS
    world_tangent = vec4(mat3(model) * tangent.xyz, tangent.w);
#endif
    gl_Position = view_projection * world;
}
