// Adds packages to the page: `node animals.mjs SITE PACKAGE...`. Writes copies of the packages to SITE/animals/, with
// the list that the page reads, in the given order.

import { copyFileSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import { basename, join } from "node:path";

const [site, ...packages] = process.argv.slice(2);
if (!site) {
  console.error("usage: node animals.mjs SITE PACKAGE...");
  process.exit(2);
}
const folder = join(site, "animals");
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });
const animals = packages.map((path, i) => {
  const name = basename(path).replace(/\.pelage$/i, "");
  // Two packages may have the same name.
  const file = `${i}.pelage`;
  try {
    copyFileSync(path, join(folder, file));
  } catch (error) {
    console.error(`${path}: ${error.message}`);
    process.exit(1);
  }
  return { name: name.slice(0, 1).toUpperCase() + name.slice(1), file: `animals/${file}` };
});
writeFileSync(join(folder, "animals.json"), `${JSON.stringify(animals, null, 2)}\n`);
