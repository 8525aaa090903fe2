// KHR_materials_retroreflection for three.js' GLTFLoader: loader.register((parser) => new Retroreflection(parser)).
import { MeshPhysicalMaterial } from 'three';

export class Retroreflection {
  constructor(parser) {
    this.parser = parser;
    this.name = 'KHR_materials_retroreflection';
  }

  #extension(index) {
    return this.parser.json.materials[index].extensions?.[this.name];
  }

  getMaterialType(index) {
    return this.#extension(index) ? MeshPhysicalMaterial : null;
  }

  extendMaterialParams(index, parameters) {
    const extension = this.#extension(index);
    if (extension) parameters.retroreflectivity = extension.retroreflectionFactor ?? 0; // three.js has no texture for it
    return Promise.resolve();
  }
}
