/** The object dictionary of a node as a tree; its objects are read and written by SDO. */

import { Download } from "lucide-react";
import { useState } from "react";
import { IconButton } from "./kit/Button.tsx";
import { Refusable } from "./kit/Refusable.tsx";
import type { Bus, ObjectEntry } from "./protocol/Ui.ts";
import { store } from "./store.ts";
import { t } from "./texts.ts";
import { hexadecimal } from "./traffic.ts";

/** Entries shown at the same time while they are searched. */
const SHOWN = 100;

const number = (entry: ObjectEntry): string => `${entry.index.toString(16).toUpperCase()}h:${entry.subindex}`;

/** The areas of an object dictionary (CiA 301, 7.4.1). */
const AREAS: readonly (readonly [last: number, name: string])[] = [
  [0x0fff, t("Data types")],
  [0x1fff, t("Communication")],
  [0x5fff, t("Manufacturer")],
  [0x9fff, t("Device profile")],
  [0xffff, t("Interface profile and others")],
];
/** Names of objects with several entries (CiA 301, 7.5.2), by their last index. */
const RECORDS: readonly (readonly [first: number, last: number, name: string])[] = [
  [0x1003, 0x1003, t("Error history")],
  [0x1010, 0x1010, t("Store parameters")],
  [0x1011, 0x1011, t("Restore parameters")],
  [0x1016, 0x1016, t("Consumer heartbeat times")],
  [0x1018, 0x1018, t("Identity")],
  [0x1029, 0x1029, t("Error behaviour")],
  [0x1200, 0x127f, t("SDO server")],
  [0x1280, 0x12ff, t("SDO client")],
  [0x1400, 0x15ff, t("RPDO communication")],
  [0x1600, 0x17ff, t("RPDO mapping")],
  [0x1800, 0x19ff, t("TPDO communication")],
  [0x1a00, 0x1bff, t("TPDO mapping")],
];

function nameOf(entries: readonly ObjectEntry[]): string {
  const { index, name } = entries[0]!;
  if (entries.length === 1) return name;
  const record = RECORDS.find(([first, last]) => index >= first && index <= last);
  if (!record) return name;
  return record[0] === record[1] ? record[2] : `${record[2]} ${index - record[0] + 1}`;
}

/** Groups entries by what a function says, in their order. */
function grouped<K>(entries: readonly ObjectEntry[], of: (entry: ObjectEntry) => K): [K, ObjectEntry[]][] {
  const groups = new Map<K, ObjectEntry[]>();
  for (const each of entries) groups.set(of(each), [...(groups.get(of(each)) ?? []), each]);
  return [...groups];
}

interface Value {
  text: string;
  octets: string;
}

export function Objects({ bus, full }: { bus: Bus; full: boolean }) {
  const [nodeId, choose] = useState(0);
  const [entries, list] = useState<readonly ObjectEntry[]>([]);
  const [filter, setFilter] = useState("");
  const [opened, open] = useState<ReadonlySet<string>>(new Set());
  const [values, setValues] = useState<ReadonlyMap<string, Value>>(new Map());
  const [edited, edit] = useState<ReadonlyMap<string, string>>(new Map());
  const [refused, refuse] = useState<ReadonlyMap<string, string>>(new Map());
  const enter = async (node_id: number) => {
    choose(node_id);
    setValues(new Map());
    edit(new Map());
    refuse(new Map());
    const result = node_id ? await store.order({ case: "node", value: { bus: bus.name, node_id } }) : undefined;
    list(result?.done ? result.objects : []);
  };
  const access = (entry: ObjectEntry, text: string) => ({ bus: bus.name, node_id: nodeId, index: entry.index, subindex: entry.subindex, text });
  const settle = (entry: ObjectEntry, reason: string) => refuse((before) => new Map(before).set(number(entry), reason));
  const read = async (entry: ObjectEntry) => {
    const result = await store.ask({ case: "read", value: access(entry, "") });
    settle(entry, result.done ? "" : result.message);
    if (result.done) setValues((before) => new Map(before).set(number(entry), { text: result.text, octets: hexadecimal(result.reply) }));
  };
  const readAll = async (some: readonly ObjectEntry[]) => {
    for (const each of some) if (each.access !== "wo") await read(each);
  };
  const write = async (entry: ObjectEntry) => {
    const result = await store.ask({ case: "written", value: access(entry, edited.get(number(entry)) ?? "") });
    settle(entry, result.done ? "" : result.message);
    if (result.done && entry.access !== "wo") await read(entry);
  };
  const forget = (entry: ObjectEntry) => {
    edit((before) => new Map(before).set(number(entry), ""));
    settle(entry, "");
  };
  const wanted = filter.toLowerCase().split(/\s+/).filter(Boolean);
  const found = wanted.length ? entries.filter((each) => wanted.every((word) => `${number(each)} ${each.name} ${each.unit}`.toLowerCase().includes(word))).slice(0, SHOWN) : entries;
  const branch = (key: string, title: string, some: readonly ObjectEntry[], inner: () => React.ReactNode) => {
    const isOpen = wanted.length > 0 || opened.has(key);
    return (
      <li key={key}>
        <details open={isOpen}>
          <summary
            onClick={(e) => {
              e.preventDefault();
              const next = new Set(opened);
              if (!next.delete(key)) next.add(key);
              open(next);
            }}
          >
            {title} <small>{some.length}</small>
          </summary>
          {isOpen && inner()}
        </details>
      </li>
    );
  };
  const leaf = (entry: ObjectEntry) => {
    const key = number(entry);
    const constant = entry.access === "ro" || entry.access === "const";
    const value = values.get(key);
    const reason = refused.get(key);
    return (
      <li key={key} className="object">
        <Refusable reason={reason}>
          {(said) => (
            <>
              <div className="what">
                <strong>{key}</strong> <bdi>{entry.name}</bdi>{" "}
                <small>
                  <bdi>{entry.type}</bdi>, <bdi>{entry.access}</bdi>
                  {entry.unit && (
                    <>
                      , <bdi>{entry.unit}</bdi>
                    </>
                  )}
                </small>
              </div>
              <div className="toolbar">
                {entry.access !== "wo" && (
                  <button type="button" disabled={!full} aria-label={t("Read {key}", { key })} onClick={() => void read(entry)}>
                    {t("Read")}
                  </button>
                )}
                <output aria-label={t("Value of {key}", { key })}>{value?.text}</output>
                {value?.octets && <span className="octets" title={t("The octets as transferred")}>{value.octets}</span>}
                {!constant && (
                  <form
                    className="group"
                    onSubmit={(e) => {
                      e.preventDefault();
                      void write(entry);
                    }}
                  >
                    <input size={9} aria-label={t("New value of {key}", { key })} {...said} disabled={!full} value={edited.get(key) ?? ""} placeholder={value?.text ?? entry.unit} onChange={(e) => edit(new Map(edited).set(key, e.target.value))} onKeyDown={(e) => e.key === "Escape" && forget(entry)} />
                    <button type="submit" disabled={!full} aria-label={t("Write {key}", { key })}>
                      {t("Write")}
                    </button>
                  </form>
                )}
              </div>
            </>
          )}
        </Refusable>
      </li>
    );
  };
  return (
    <section aria-label={t("Object dictionary")}>
      <h2>{t("Object dictionary")}</h2>
      <div className="toolbar">
        <label>
          {t("Node")}
          <select value={nodeId} onChange={(e) => void enter(Number(e.target.value))}>
            <option value={0}>{t("none")}</option>
            {bus.nodes.map((each) => (
              <option key={each.node_id} value={each.node_id}>
                {each.name}
              </option>
            ))}
          </select>
        </label>
        {nodeId > 0 && entries.length > 0 && <input type="search" aria-label={t("Objects")} placeholder={t("6083, a name, a unit")} value={filter} onChange={(e) => setFilter(e.target.value)} />}
      </div>
      {nodeId > 0 && entries.length > 0 && (
        <ul className="tree objects" aria-label={t("Entries")}>
          {grouped(found, (each) => AREAS.find(([last]) => each.index <= last)![1]).map(([area, inArea]) =>
            branch(area, area, inArea, () => (
              <ul>
                {grouped(inArea, (each) => each.index).map(([index, some]) => {
                  const own = entries.filter((each) => each.index === index);
                  if (own.length === 1) return leaf(own[0]!);
                  const title = `${index.toString(16).toUpperCase()}h ${nameOf(own)}`;
                  return branch(title, title, some, () => (
                    <ul>
                      <li>
                        <IconButton icon={Download} look="plain" label={t("Read all of {title}", { title })} disabled={!full} onClick={() => void readAll(some)} />
                      </li>
                      {some.map(leaf)}
                    </ul>
                  ));
                })}
              </ul>
            )),
          )}
        </ul>
      )}
      {nodeId > 0 && wanted.length > 0 && !found.length && <p className="empty">{t("No object matches.")}</p>}
      {nodeId > 0 && !entries.length && <p>{t("No description of this node is known.")}</p>}
    </section>
  );
}
