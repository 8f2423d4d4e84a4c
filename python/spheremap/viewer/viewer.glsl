// What the page draws with. Maps are no part of it: image0_encode, own_encode, screen_decode,
// globe_encode ... stand in front, printed by the library. The world is x right, y up, -z ahead.
//
// What is switched off is not compiled: renderers in software run both sides of a branch. With MOVING
// a pixel is one lookup by the texture unit, whose weights have 8 bits.

precision highp sampler2DArray;

uniform vec4 rect;    // the viewport in pixels of the canvas: left, bottom, width, height
uniform vec2 scale;   // how much of the screen's (u, v) it shows
uniform mat3 pose;    // from the camera to the world
uniform int samples;  // of a pixel that sees many texels, along a side

#if defined(PICK)

uniform vec2 at;  // the pixel
layout(location = 0) out uvec4 sight_bits;  // direction, and whether the screen holds it
layout(location = 1) out uvec4 place_bits;  // u, v, face, steradians per unit of du dv
layout(location = 2) out uvec4 apart_bits;  // the same with faces apart

#elif defined(LOCATE)

uniform highp sampler2D points;
layout(location = 0) out uvec4 place_bits;  // u, v on the screen

#else

struct Grid {
    vec4 place;  // (u, v) times xy plus zw are columns and rows
    float gain;
};
uniform sampler2DArray texels[2];
uniform Grid grids[2];
#ifdef DETAIL
uniform sampler2DArray details[2];  // what a perspective, or this screen, sees of the whole image, sharper
uniform mat3 detail_pose[2];
uniform vec3 detail_scale[2];       // its part of the widest lens or of the screen, and its gain: 0 for none
#ifdef OWN_SCREEN
#define DETAIL_ENCODE screen_encode
#else
#define DETAIL_ENCODE detail_encode
#endif
#endif
uniform int comparison;     // 0 the first image, 1 the second, 2 split, 3 difference, 4 signed
uniform float split;        // where, from the left edge, 0 to 1
uniform float exposure;     // in stops
uniform int curve;          // 0 none, 1 reinhard
uniform float white;        // light that reinhard shows as white
uniform vec3 ramp[17];      // colors of -8 to 8 stops
uniform float graticule;    // degrees between lines
uniform float mean_density; // steradians per unit of du dv, on average
uniform vec2 circles;       // their radius, and degrees between them
uniform vec3 outside;       // the color of what holds no sphere
uniform vec3 missing;       // and of NaN
out vec4 color;

#endif

// NaN by its bits: a compiler may take it that there is none.
bool is_nan(float x) {
    return (floatBitsToUint(x) & 0x7fffffffu) > 0x7f800000u;
}

// The direction that a pixel sees.
vec3 sight(vec2 pixel, out bool held) {
    vec2 part = (pixel - rect.xy) / rect.zw;
    vec2 uv = 0.5 + (vec2(part.x, 1.0 - part.y) - 0.5) * scale;
    held = screen_holds(uv);
    return pose * screen_decode(uv);
}

#if defined(PICK)

void main() {
    bool held;
    vec3 d = sight(at, held);
    vec3 place = own_place(d);
    sight_bits = floatBitsToUint(vec4(d, held ? 1.0 : 0.0));
    place_bits = floatBitsToUint(vec4(place, own_solid(place)));
    apart_bits = floatBitsToUint(vec4(image0_place(d), 0.0));
}

#elif defined(LOCATE)

void main() {
    vec3 d = texelFetch(points, ivec2(gl_FragCoord.xy), 0).xyz;
    vec2 uv = screen_encode(transpose(pose) * d);
    vec2 part = 0.5 + (uv - 0.5) / scale;
    place_bits = floatBitsToUint(vec4(part, 0.0, 0.0));
}

#else

// Light of four texels by their weights, and what they are: 1 values, 0 outside, -1 NaN. Texels
// that are no values are black.
#ifdef MOVING
vec4 lookup(sampler2DArray image, Grid grid, vec3 uvf) {
    vec2 place = uvf.xy * grid.place.xy + grid.place.zw + 0.5;
    vec4 found = textureLod(image, vec3(place / vec2(textureSize(image, 0).xy), uvf.z), 0.0);
    if (is_nan(uvf.x) || abs(found.a) < 0.004) return vec4(0.0);
    return vec4(clamp(found.rgb / found.a, -65504.0, 65504.0) * grid.gain, sign(found.a));
}
#else
vec4 lookup(sampler2DArray image, Grid grid, vec3 uvf) {
    if (is_nan(uvf.x)) return vec4(0.0);
    vec2 place = uvf.xy * grid.place.xy + grid.place.zw;
    vec2 low = floor(place), part = place - low, rest = 1.0 - part;
    ivec2 first = clamp(ivec2(low), ivec2(0), textureSize(image, 0).xy - 2);
    ivec3 at = ivec3(first, int(uvf.z + 0.5));
    vec4 weights = vec4(rest.x, part.x, rest.x, part.x) * vec4(rest.yy, part.yy);
    vec4[4] four = vec4[4](texelFetch(image, at, 0), texelFetch(image, at + ivec3(1, 0, 0), 0),
        texelFetch(image, at + ivec3(0, 1, 0), 0), texelFetch(image, at + ivec3(1, 1, 0), 0));
    vec4 kinds = vec4(four[0].a, four[1].a, four[2].a, four[3].a), known = weights * max(kinds, 0.0);
    if (dot(weights, max(-kinds, 0.0)) > 1e-6) return vec4(vec3(0.0), -1.0);
    vec3 light = vec3(0.0);
    // Infinite light is white, and no NaN between texels.
    for (int k = 0; k < 4; k++) light += known[k] * clamp(four[k].rgb, -65504.0, 65504.0);
    float sum = known.x + known.y + known.z + known.w;
    return sum > 1e-6 ? vec4(light / sum * grid.gain, 1.0) : vec4(0.0);
}
#endif

#ifdef DETAIL
// What lies in the sharper picture; the fourth is -2 where that ends.
vec4 detailed(sampler2DArray image, mat3 own, vec3 scale, vec3 d) {
    vec2 part = 0.5 + (DETAIL_ENCODE(d * own) - 0.5) / scale.xy, size = vec2(textureSize(image, 0).xy);
    vec2 edge = min(part, 1.0 - part) * size - 1.0;
    if (scale.z == 0.0 || is_nan(part.x) || min(edge.x, edge.y) < 0.0) return vec4(0.0, 0.0, 0.0, -2.0);
    return lookup(image, Grid(vec4(size, -0.5, -0.5), scale.z), vec3(part, 0.0));
}
#define SHARPER(K) \
    if (held) { \
        vec4 sharp = detailed(details[K], detail_pose[K], detail_scale[K], center); \
        if (sharp.a > -1.5) return sharp; \
    }
#else
#define SHARPER(K)
#endif

// What a pixel sees of an image: one lookup, or a mean where it sees more than a texel.
#ifdef MOVING
#define SEEN(NAME, PLACE, K) \
    vec4 NAME(vec3 center, bool held) { \
        SHARPER(K) \
        return held ? lookup(texels[K], grids[K], PLACE(center)) : vec4(0.0); \
    }
#else
#define SEEN(NAME, PLACE, K) \
    vec4 NAME(vec3 center, bool held) { \
        vec3 uvf = PLACE(center); \
        vec2 wide = fwidth(uvf.xy) * grids[K].place.xy; \
        SHARPER(K) \
        int n = clamp(int(ceil(max(wide.x, wide.y) - 0.01)), 1, samples); \
        if (n == 1) return held ? lookup(texels[K], grids[K], uvf) : vec4(0.0); \
        vec4 sum = vec4(0.0); \
        for (int i = 0; i < n * n; i++) { \
            vec2 offset = (vec2(i % n, i / n) + 0.5) / float(n) - 0.5; \
            bool inside; \
            vec3 d = sight(gl_FragCoord.xy + offset, inside); \
            if (!inside) continue; \
            vec4 one = lookup(texels[K], grids[K], PLACE(d)); \
            if (one.a < 0.0) return one; \
            sum += vec4(one.rgb * one.a, one.a); \
        } \
        return held && sum.a > 0.0 ? vec4(sum.rgb / sum.a, 1.0) : vec4(0.0); \
    }
#endif

SEEN(seen0, image0_place, 0)
#ifdef SECOND
SEEN(seen1, image1_place, 1)
#endif

// IEC 61966-2-1.
vec3 encoded(vec3 light) {
    vec3 high = 1.055 * pow(max(light, 0.0031308), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, 12.92 * light, lessThanEqual(light, vec3(0.0031308)));
}

vec3 toned(vec3 light) {
    light = clamp(light, 0.0, 1e12);
    if (curve == 1) light = light * (1.0 + light / (white * white)) / (1.0 + light);
    return encoded(min(light, 1.0));
}

vec3 ramped(float stops) {
    float place = clamp(stops + 8.0, 0.0, 16.0);
    int low = min(int(place), 15);
    return mix(ramp[low], ramp[low + 1], place - float(low));
}

// How much a pixel lies on a line so many pixels wide, where `place` is a whole number.
float line(float place, float slope, float wide) {
    float away = abs(fract(place + 0.5) - 0.5);
    // Lines that lie closer than a few pixels are none.
    return clamp(0.5 + 0.5 * wide - away / max(slope, 1e-9), 0.0, 1.0) * clamp(2.0 - 8.0 * slope, 0.0, 1.0);
}

#ifdef TISSOT
// Circles about so many degrees apart, on parallels: how much a pixel lies in one, and on its rim.
vec2 circled(vec3 d) {
    vec2 globe = globe_encode(d);
    float rows = 180.0 / circles.y, half_turn = 3.14159265;
    float row = clamp(floor(globe.y * rows), 0.0, rows - 1.0);
    float latitude = (0.5 - (row + 0.5) / rows) * half_turn, here = (0.5 - globe.y) * half_turn;
    float count = max(3.0, floor(360.0 / circles.y * cos(latitude) + 0.5));
    float apart = (globe.x - (floor(globe.x * count) + 0.5) / count) * 2.0 * half_turn;
    // By haversines, which have the digits of small angles.
    vec2 part = sin(0.5 * vec2(here - latitude, apart));
    float away = 2.0 * asin(sqrt(min(part.x * part.x + cos(here) * cos(latitude) * part.y * part.y, 1.0)));
    float pixel = length(dFdx(d)) * 0.5 + length(dFdy(d)) * 0.5;
    float beyond = (away - radians(circles.x)) / max(pixel, 1e-9);
    return vec2(clamp(0.5 - beyond, 0.0, 1.0), clamp(1.25 - abs(beyond), 0.0, 1.0));
}

#endif

#ifdef SEAMS
// Whether the image ends, or goes on elsewhere, between a pixel and its neighbors.
bool on_seam(vec3 d) {
    vec3 here = image0_place(d);
    if (is_nan(here.x)) return false;
    for (int k = 0; k < 4; k++) {
        bool inside;
        vec3 there = image0_place(sight(gl_FragCoord.xy + vec2(k % 2, 1 - k % 2) * float(k / 2 * 2 - 1), inside));
        if (!inside) continue;
        if (is_nan(there.x) || abs(there.z - here.z) > 0.5) return true;
        vec2 jump = abs(there.xy - here.xy), edge = min(here.xy, 1.0 - here.xy);
        // Over an edge of the image there is a fold, whose sides are as far from it.
        if (max(jump.x, jump.y) > 0.1 || edge.x < jump.x || edge.y < jump.y) return true;
    }
    return false;
}
#endif

void main() {
    bool held;
    vec3 d = sight(gl_FragCoord.xy, held);
    float across = (gl_FragCoord.x - rect.x) / rect.z;
    vec4 first = seen0(d, held), found = first;
#ifdef SECOND
    vec4 second = seen1(d, held);
    float kind = min(first.a, second.a);
    if (comparison == 1 || (comparison == 2 && across >= split)) found = second;
    if (comparison == 3) found = vec4(abs(first.rgb - second.rgb), kind);
    if (comparison == 4) found = vec4(first.rgb - second.rgb, kind);
#endif
    vec3 light = found.rgb * exp2(exposure);
#if defined(FALSE_COLOR) || defined(ISOLINES)
    float luminance = dot(light, vec3(0.2126, 0.7152, 0.0722));
    float stops = log2(max(luminance, 1e-12));
#endif

#ifdef FALSE_COLOR
    vec3 shown = ramped(stops);
#else
    vec3 shown = toned(light);
#endif
#ifdef SECOND
    // No difference is gray.
    if (comparison == 4) shown = clamp(0.5 + 0.5 * light, 0.0, 1.0);
#endif
#ifdef ISOLINES
    float drawn = luminance > 0.0 ? line(stops, fwidth(stops), 1.4) : 0.0;
    shown = mix(shown, vec3(0.0), 0.8 * drawn);
#endif
    bool stripe = fract((gl_FragCoord.x + gl_FragCoord.y) / 12.0) < 0.5;
#ifdef CLIPPING
    if (stripe) {
        float top = max(light.r, max(light.g, light.b));
        if (top >= (curve == 1 ? white : 1.0)) shown = vec3(0.9, 0.0, 0.0);
        if (min(light.r, min(light.g, light.b)) < 0.0) shown = vec3(0.0, 0.2, 0.9);
    }
#endif
    if (found.a < 0.0) {
        ivec2 cell = ivec2(gl_FragCoord.xy) / 6;
        shown = ((cell.x + cell.y) & 1) == 0 ? missing : vec3(0.0);
    }
    if (found.a == 0.0) shown = outside;
#ifdef VALID
    if (found.a == 0.0 && stripe) shown = vec3(0.55, 0.1, 0.1);
#endif
#ifdef DENSITY
    vec3 place = own_place(d);
    if (!is_nan(place.x)) {
        float parts = log2(own_solid(place) / mean_density);
        // Four powers of two either way.
        if (!is_nan(parts)) shown = mix(shown, ramped(2.0 * parts), 0.7);
    }
#endif
#ifdef SEAMS
    if (on_seam(d)) shown = vec3(1.0, 0.85, 0.1);
#endif
#ifdef TISSOT
    vec2 circle = circled(d);
    shown = mix(mix(shown, vec3(0.82, 0.25, 0.25), 0.5 * circle.x), vec3(0.5, 0.05, 0.05), circle.y);
#endif

#ifdef GRATICULE
    {
        vec2 globe = globe_encode(d) * vec2(360.0, 180.0) / graticule;
        // Its longitude jumps by a turn; half a turn further it does not.
        float turn = 360.0 / graticule;
        float east = min(fwidth(globe.x), fwidth(fract(globe.x / turn + 0.5) * turn));
        float north = fwidth(globe.y);
        // White in black, to be seen on anything.
        shown *= 1.0 - 0.45 * max(line(globe.x, east, 3.0), line(globe.y, north, 3.0));
        shown = mix(shown, vec3(1.0), 0.65 * max(line(globe.x, east, 1.0), line(globe.y, north, 1.0)));
    }
#endif
#ifdef SECOND
    if (comparison == 2 && abs(across - split) * rect.z < 1.0) shown = vec3(1.0);
#endif
    color = vec4(held ? shown : outside, 1.0);
}

#endif
