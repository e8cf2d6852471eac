/**
 * The texts of the page, and what is wrong with them, as JSON: `{ "texts": [place, text][], "flaws": [place, what][] }`.
 *
 * A text is the constant that `t` of src/texts.ts and `rich` of src/rich.tsx are called with. It is a flaw that a text of JSX, of an
 * attribute that people see, or of any other constant with words, is not one.
 */

import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { parseSync } from "rolldown/utils";

const SOURCES = join(import.meta.dirname, "src");
/** The page of all components is for those who change them; the protocol is generated. */
const LEFT_OUT = /^(kit\/Gallery\.tsx$|protocol\/|texts\.ts$)/;
/** Attributes, and properties of objects, that people see. */
const SEEN = new Set(["alt", "aria-description", "aria-label", "aria-valuetext", "ariaLabel", "caption", "heading", "label", "placeholder", "summary", "tip", "title"]);
/** Attributes `name` of these components, and first arguments of these functions. */
const NAMED = new Set(["Card", "Folded", "Limit", "Question", "Row"]);
const SAYING = new Set(["end", "fail", "item", "list", "notify", "order", "refuse"]);
/** Functions whose arguments are selectors. */
const SELECTING = new Set(["closest", "matches", "querySelector", "querySelectorAll"]);
/** Attributes that are for machines, whatever words they have. */
const UNSEEN = new Set(["className", "class", "style", "d", "id", "viewBox", "pattern", "nodeClassName", "contentClassName", "overlayClassName", "preserveAspectRatio", "key", "aria-describedby"]);
/** What is the same in all languages. */
const UNITS = /^(?:[^\p{L}]|\b(?:Hz|NMT|kbit\/s|kbit|km?|m|cm|mm|m\/s|rad\/s|rad|ms|s|µs|x|y|hex|id|EMCY|OK|R|t|rtgen)\b|σ)*$/u;
/** A constant with two words is a text, wherever it stands. */
const PROSE = /(?<![\w.:(=-])\p{L}{2,}[,;:.]? \p{Ll}{2,}/u;

/** A number before the plural of a noun, which would stand after 1 as well. */
const COUNTED = /\{count\} \p{Ll}+s\b|\{(\w+s)\} \1\b/u;

/** Names under which the browser stores something. */
const STORED = /^rtgen [a-z]+$/;

const texts = [];
const flaws = [];

for (const file of readdirSync(SOURCES, { recursive: true }).map((each) => each.replaceAll("\\", "/")).sort()) {
  if (!/\.tsx?$/.test(file) || LEFT_OUT.test(file)) continue;
  const source = readFileSync(join(SOURCES, file), "utf8");
  const { program, errors } = parseSync(file, source);
  if (errors.length) throw new Error(`${file}: ${errors[0].message}`);
  const at = ({ start }) => `${file}:${source.slice(0, start).split("\n").length}`;

  /** The constants of an expression that may be its value. */
  const constants = (node) => {
    switch (node?.type) {
      case "Literal":
        return typeof node.value === "string" ? [[node, node.value]] : [];
      case "TemplateLiteral":
        return [[node, node.quasis.map((each) => each.value.cooked).join("\0")], ...node.expressions.flatMap(constants)];
      case "ConditionalExpression":
        return [...constants(node.consequent), ...constants(node.alternate)];
      case "LogicalExpression":
        return [...constants(node.left), ...constants(node.right)];
      case "BinaryExpression":
        return node.operator === "+" ? [...constants(node.left), ...constants(node.right)] : [];
      case "JSXExpressionContainer":
        return constants(node.expression);
      case "TSAsExpression":
      case "TSNonNullExpression":
      case "ParenthesizedExpression":
        return constants(node.expression);
      default:
        return [];
    }
  };
  /** A text that people see must be a call of `t`. */
  const see = (node) => {
    for (const [where, text] of constants(node)) if (!UNITS.test(text)) flaws.push([at(where), text.replaceAll("\0", "{}")]);
  };
  const walk = (node, parent) => {
    if (Array.isArray(node)) return node.forEach((each) => walk(each, parent));
    if (!node || typeof node.type !== "string") return undefined;
    switch (node.type) {
      case "ImportDeclaration":
      case "TSTypeAliasDeclaration":
      case "TSInterfaceDeclaration":
      case "TSTypeAnnotation":
        return undefined;
      case "CallExpression":
        if (["t", "rich"].includes(node.callee.name)) return called(node);
        if (SELECTING.has(node.callee.property?.name)) return undefined;
        if (SAYING.has(node.callee.name ?? node.callee.property?.name)) see(node.arguments[0]);
        break;
      case "JSXElement":
        // What a key is called is on the key.
        if (node.openingElement.name.name === "kbd") return undefined;
        node.children.filter((each) => each.type === "JSXExpressionContainer").forEach(see);
        break;
      case "JSXText":
        if (!UNITS.test(node.value)) flaws.push([at(node), node.value.trim()]);
        return undefined;
      case "JSXAttribute":
        if (UNSEEN.has(node.name.name)) return undefined;
        if (node.value && (SEEN.has(node.name.name) || (node.name.name === "name" && NAMED.has(parent?.name?.name)))) see(node.value);
        break;
      case "NewExpression":
        if (/Error$/.test(node.callee.name)) see(node.arguments[0]);
        break;
      case "ObjectExpression":
        // An item of a menu.
        if (node.properties.some((each) => each.key?.name === "act")) node.properties.filter((each) => each.key?.name === "name").forEach((each) => see(each.value));
        break;
      case "Property":
        if (SEEN.has(node.key.name ?? node.key.value)) see(node.value);
        break;
      case "Literal":
        if (typeof node.value === "string" && PROSE.test(node.value) && !STORED.test(node.value)) flaws.push([at(node), node.value]);
        return undefined;
      case "TemplateElement":
        if (PROSE.test(node.value.cooked)) flaws.push([at(node), node.value.cooked]);
        return undefined;
    }
    for (const [key, each] of Object.entries(node)) if (key !== "type" && each && typeof each === "object") walk(each, node);
    return undefined;
  };
  const called = (node) => {
    const [english, values] = node.arguments;
    const found = constants(english).filter(([where]) => !where.expressions?.length);
    if (!found.length) flaws.push([at(node), "the text is not a constant"]);
    const given = values?.type === "ObjectExpression" ? values.properties.map((each) => each.key?.name) : [];
    for (const [where, text] of found) {
      texts.push([at(where), text]);
      for (const [, name] of text.matchAll(/\{(\w+)[:}]/g)) if (!given.includes(name)) flaws.push([at(where), `no value of {${name}}`]);
      if (COUNTED.test(text)) flaws.push([at(where), `a plural for 1: ${text}`]);
    }
    walk(values);
  };
  walk(program.body);
}

console.log(JSON.stringify({ texts, flaws }));
