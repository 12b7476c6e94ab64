/**
 * What the viewer paints with: few small programs, ready sooner on a telephone than three.js's
 * general ones, and the light of the two still pictures (model/rendering.py), so that the body in
 * 3D takes their place unnoticed.
 */

import { Color, DoubleSide, ShaderMaterial } from "three";

/** sRGB: a shop's mannequin and a garment that is clearly one, as in the file and the pictures. */
export const GARMENT = [0.36, 0.42, 0.47];
const GHOST = [0.06, 0.42, 0.46];

const VERTEX = /* glsl */ `
varying vec3 facing;
varying float upwards;
void main() {
  facing = normalMatrix * normal;
  upwards = normal.y;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

/*
 * A broad warm lamp above the camera's left shoulder, a weak cool one from the right, light from
 * the ceiling and back from the floor, and a little at the edges. Reckoned linearly, shown as sRGB.
 */
const LIT = /* glsl */ `
uniform vec3 colour;
varying vec3 facing;
varying float upwards;
float lamp(vec3 normal, vec3 direction, float wrap) {
  return max(0.0, (dot(normal, normalize(direction)) + wrap) / (1.0 + wrap));
}
vec3 srgb(vec3 light) {
  vec3 c = clamp(light, 0.0, 1.0);
  return mix(1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, 12.92 * c, step(c, vec3(0.0031308)));
}
void main() {
  vec3 normal = normalize(facing);
  float up = clamp(upwards, -1.0, 1.0);
  float edge = pow(1.0 - clamp(normal.z, 0.0, 1.0), 3.0);
  vec3 light =
    pow(lamp(normal, vec3(-0.6, 0.55, 0.75), 0.15), 1.2) * vec3(1.0, 0.975, 0.93)
    + pow(lamp(normal, vec3(0.9, 0.1, 0.35), 0.2), 1.5) * vec3(0.15, 0.17, 0.20)
    + (0.5 + 0.5 * up) * vec3(0.19, 0.20, 0.22)
    + (0.5 - 0.5 * up) * vec3(0.10, 0.09, 0.08)
    + edge * vec3(0.10);
  gl_FragColor = vec4(srgb(colour * light), 1.0);
}`;

/*
 * The outline of a body that was: clearest at its edge. Its depths are told a little farther than
 * they are, so that it shows where it was larger and not where it was the same.
 */
const FAINT_VERTEX = /* glsl */ `
varying vec3 facing;
varying vec3 towards;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  vec4 farther = projectionMatrix * (seen - vec4(0.0, 0.0, 0.005, 0.0));
  facing = normalMatrix * normal;
  towards = -seen.xyz;
  gl_Position = projectionMatrix * seen;
  gl_Position.z = farther.z / farther.w * gl_Position.w;
}`;

const FAINT = /* glsl */ `
uniform vec3 colour;
uniform float opacity;
varying vec3 facing;
varying vec3 towards;
void main() {
  float edge = 1.0 - abs(dot(normalize(facing), normalize(towards)));
  gl_FragColor = vec4(colour, opacity * (0.18 + 0.5 * edge * edge));
}`;

/* Depths are told a little nearer than they are, so that a band lies on the skin everywhere. */
const BAND_VERTEX = /* glsl */ `
attribute vec3 tint;
varying vec3 colour;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  vec4 nearer = projectionMatrix * (seen + vec4(0.0, 0.0, 0.011, 0.0));
  gl_Position = projectionMatrix * seen;
  gl_Position.z = nearer.z / nearer.w * gl_Position.w;
  colour = tint;
}`;

const PLAIN = /* glsl */ `
varying vec3 colour;
void main() {
  gl_FragColor = vec4(colour, 1.0);
}`;

const DISC_VERTEX = /* glsl */ `
varying vec2 place;
void main() {
  place = position.xy;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

/* A soft shadow on the floor, darkest under the feet, so that the person stands on something. */
const DISC = /* glsl */ `
uniform float feet;
varying vec2 place;
float shade(vec2 from, float reach) {
  float light = max(0.0, 1.0 - dot(from, from) / (reach * reach));
  return light * light;
}
void main() {
  float foot = shade(vec2(abs(place.x) - feet, place.y), 0.42);
  gl_FragColor = vec4(0.0, 0.0, 0.0, max(0.1 * shade(place, 1.0), 0.36 * foot));
}`;

const clear = { transparent: true, depthWrite: false };

/** A lit surface of one colour, sRGB from 0 to 1. */
export function lit(colour) {
  const material = new ShaderMaterial({
    uniforms: { colour: { value: new Color() } },
    vertexShader: VERTEX,
    fragmentShader: LIT,
  });
  paint(material, colour);
  return material;
}

/** Give a lit surface another colour. */
export function paint(material, [red, green, blue]) {
  material.uniforms.colour.value.setRGB(red, green, blue, "srgb");
}

export function faint() {
  return new ShaderMaterial({
    uniforms: { colour: { value: new Color(...GHOST) }, opacity: { value: 1 } },
    vertexShader: FAINT_VERTEX,
    fragmentShader: FAINT,
    ...clear,
  });
}

export function taped() {
  return new ShaderMaterial({
    vertexShader: BAND_VERTEX,
    fragmentShader: PLAIN,
    side: DoubleSide,
  });
}

export function shaded() {
  return new ShaderMaterial({
    uniforms: { feet: { value: 0 } },
    vertexShader: DISC_VERTEX,
    fragmentShader: DISC,
    ...clear,
  });
}
