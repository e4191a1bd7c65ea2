/**
 * Shader text for light: materials, lamps, surroundings, shadows, exposure and tone curve.
 *
 * @module
 */

/** Display transform: exposure, linear tone curve, sRGB encoding. */
export const TONE_TEXT = `
vec3 encode(vec3 linear) {
  vec3 x = clamp(linear, 0.0, 1.0);
  return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}
// What is no number, and what is below 0, is no light.
vec3 display(vec3 light, float gain) {
  vec3 known = vec3(light.x > 0.0 ? light.x : 0.0, light.y > 0.0 ? light.y : 0.0, light.z > 0.0 ? light.z : 0.0);
  return encode(min(known * gain, vec3(1.0)));
}
`;

/** `struct Material` and `materialOf`. Four texels each. */
const MATERIAL = `
uniform sampler2D materials;
struct Material { vec3 base; float metallic; vec3 specular; float roughness; vec3 emission; float opacity; float exponent; bool glass; };
Material materialOf(uint number) {
  uint at = number * 4u;
  ivec2 place = ivec2(at & 2047u, at >> 11u);
  vec4 a = texelFetch(materials, place, 0), b = texelFetch(materials, place + ivec2(1, 0), 0);
  vec4 c = texelFetch(materials, place + ivec2(2, 0), 0), d = texelFetch(materials, place + ivec2(3, 0), 0);
  return Material(a.xyz, a.w, b.xyz, b.w, c.xyz, c.w, d.x, d.y > 0.0);
}
`;

/** `float lit(vec3 p, vec3 n, float cosine)`: what share of the light with shadows arrives. */
const SHADOW = `
uniform highp sampler2DShadow shadowMap;
float depthSample(vec2 at, vec2 low, vec2 high, float depth) {
  vec2 texel = 1.0 / vec2(textureSize(shadowMap, 0));
  // Beyond the map nothing is known to throw a shadow; its depths end at 1.
  depth = min(depth, 1.0);
  float sum = 0.0;
  // Each is a mean of four texels by itself.
  for (int k = 0; k < 4; k++) {
    vec2 offset = texel * vec2(k % 2 == 0 ? -0.75 : 0.75, k < 2 ? -0.75 : 0.75);
    sum += texture(shadowMap, vec3(clamp(at + offset, low, high), depth));
  }
  return 0.25 * sum;
}
float lit(vec3 p, vec3 n, float cosine) {
  if (shadow.x == 0.0) return 1.0;
  vec3 l = vec3(dot(shadowX.xyz, p) + shadowX.w, dot(shadowY.xyz, p) + shadowY.w, dot(shadowZ.xyz, p) + shadowZ.w);
  vec3 m = vec3(dot(shadowX.xyz, n), dot(shadowY.xyz, n), dot(shadowZ.xyz, n));
  vec2 size = vec2(textureSize(shadowMap, 0));
  // The place is moved off the surface by what the samples around it reach, more under slanting light.
  float slant = 1.0 + 2.0 * sqrt(max(0.0, 1.0 - cosine * cosine));
  if (shadow.x == 1.0) {
    l += m * slant * shadow.y / size.x;
    vec2 at = l.xy / shadow.y + 0.5;
    if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, vec2(1.0)))) return 1.0;
    return depthSample(at, vec2(0.0), vec2(1.0), 0.5 + 0.5 * (l.z * shadow.z + shadow.w));
  }
  // Six faces of a cube, three beside each other in two rows: +x +y +z, then -x -y -z.
  vec3 reach = abs(l);
  float w = max(reach.x, max(reach.y, reach.z));
  l += m * slant * 2.0 * w / (size.x / 3.0);
  reach = abs(l);
  int axis = reach.x >= reach.y && reach.x >= reach.z ? 0 : reach.y >= reach.z ? 1 : 2;
  vec3 turned = axis == 0 ? l.yzx : axis == 1 ? l.zxy : l;
  w = abs(turned.z);
  vec2 cell = vec2(axis, turned.z < 0.0 ? 1 : 0), cells = vec2(3.0, 2.0);
  vec2 at = (cell + 0.5 + 0.5 * turned.xy / w) / cells;
  vec2 margin = 0.5 / size;
  return depthSample(at, cell / cells + margin, (cell + 1.0) / cells - margin, 0.5 + 0.5 * (shadow.z + shadow.w / w));
}
`;

/** `vec3 reflected(...)`: what a material sends to the eye, and how much of the light from behind it covers. */
const REFLECTION = `
const float PI = 3.14159265358979;
vec3 surroundings(vec3 direction) {
  return mix(ground.xyz, sky.xyz, smoothstep(-0.2, 0.6, dot(direction, upward.xyz)));
}
float squared(float x) { return x * x; }

// Specular part of the GGX model (@walter2007) with Smith's shadowing in one term (@heitz2014), times the cosine at the surface.
vec3 glossy(vec3 f0, float alpha, vec3 n, vec3 toEye, vec3 toLight) {
  vec3 middle = normalize(toEye + toLight);
  float nl = max(dot(n, toLight), 1e-4), nv = max(dot(n, toEye), 1e-4), nh = dot(n, middle);
  float a2 = alpha * alpha;
  float d = a2 / (PI * squared(nh * nh * (a2 - 1.0) + 1.0));
  float g = 0.5 / (nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2));
  vec3 f = f0 + (1.0 - f0) * pow(1.0 - max(dot(toEye, middle), 0.0), 5.0);
  return f * d * g * nl;
}

// Irradiance of a light on a surface that faces it, and the direction to it.
vec3 arriving(Light light, vec3 p, out vec3 toLight) {
  if (light.position.w == 0.0) {
    toLight = -light.direction.xyz;
    return light.intensity.xyz;
  }
  vec3 away = light.position.xyz - p;
  float square = max(dot(away, away), 1e-12);
  toLight = away * inversesqrt(square);
  if (light.reach.x > 0.0 && square > squared(light.reach.x)) return vec3(0.0);
  float cosine = -dot(toLight, light.direction.xyz), share = 1.0;
  if (light.position.w == 2.0) share = smoothstep(light.intensity.w, light.direction.w, cosine);
  if (light.position.w == 3.0) share = max(cosine, 0.0);
  return light.intensity.xyz * share / square;
}

vec4 reflected(Material m, vec3 p, vec3 n, vec3 toEye, bool front) {
  vec3 diffuse = m.base * (1.0 - m.metallic) / PI;
  bool phong = m.exponent >= 0.0;
  vec3 f0 = mix(phong ? vec3(0.0) : m.specular, m.base, m.metallic);
  if (m.glass) f0 = max(f0, vec3(0.04));
  bool shiny = any(greaterThan(f0, vec3(0.0)));
  float alpha = squared(m.roughness);
  vec3 mirrored = reflect(-toEye, n);
  vec3 rough = vec3(0.0), bright = vec3(0.0);
  int count = int(sky.w);
  for (int k = 0; k < count; k++) {
    vec3 toLight;
    vec3 e = arriving(lights[k], p, toLight);
    float cosine = dot(n, toLight);
    if (cosine <= 0.0 || e == vec3(0.0)) continue;
    if (lights[k].reach.y > 0.0) e *= lit(p, n, cosine);
    rough += diffuse * e * cosine;
    // A lamp has a size; a point of light in a mirror would be seen in no pixel.
    if (shiny) bright += glossy(f0, max(alpha, lights[k].position.w == 3.0 ? 0.08 : 0.004), n, toEye, toLight) * e;
    if (phong) {
      float lobe = (m.exponent + 2.0) / (2.0 * PI) * pow(max(dot(mirrored, toLight), 0.0), m.exponent);
      bright += m.specular * lobe * cosine * e;
    }
  }
  // The surroundings are of two halves, whose irradiance is that of a sphere of two colours.
  float above = 0.5 + 0.5 * dot(n, upward.xyz);
  vec3 ambient = mix(ground.xyz, sky.xyz, above) * fill.xyz;
  rough += m.base * (1.0 - m.metallic) * ambient;
  float cover = m.opacity;
  if (shiny) {
    float grazing = pow(1.0 - clamp(dot(n, toEye), 0.0, 1.0), 5.0);
    vec3 f = f0 + (max(vec3(1.0 - m.roughness), f0) - f0) * grazing;
    bright += f * mix(surroundings(mirrored), mix(ground.xyz, sky.xyz, above), squared(m.roughness));
    cover = mix(m.opacity, 1.0, max(f.x, max(f.y, f.z)));
  }
  if (phong) bright += m.specular * mix(ground.xyz, sky.xyz, 0.5 + 0.5 * dot(mirrored, upward.xyz)) * fill.xyz;
  vec3 light = m.opacity * rough + bright;
  if (front) light += m.emission;
  return vec4(light / max(cover, 1e-3), cover);
}
`;

/** All of it. */
export const SHADING_TEXT = TONE_TEXT + MATERIAL + SHADOW + REFLECTION;
