/** All components of the page beside each other, at `#components`: to be looked at, and drawn by a test. */

import { Pencil, Play, Plus, RotateCcw, Square, Undo2, X } from "lucide-react";
import * as Tooltip from "@radix-ui/react-tooltip";
import { useState } from "react";
import { Group, Panel as Pane, Separator } from "react-resizable-panels";
import { Menu } from "../Menu.tsx";
import { Button, IconButton } from "./Button.tsx";
import { Dialog, Question } from "./Dialog.tsx";
import { Refusable } from "./Refusable.tsx";
import { Tabs } from "./Tabs.tsx";

const VIEWS = ["Values", "Connections", "Timeline"] as const;
const STATES = [
  ["CREATED", "STATE_CREATED"],
  ["INACTIVE", "STATE_INACTIVE"],
  ["ACTIVE", "STATE_ACTIVE"],
  ["ERROR", "STATE_ERROR"],
  ["FINISHED", "FINISHED"],
] as const;

export function Gallery() {
  const [view, show] = useState<(typeof VIEWS)[number]>("Values");
  const [asked, ask] = useState<"window" | "question" | "menu">();
  const [pressed, press] = useState(true);
  return (
    <Tooltip.Provider>
      <main className="gallery">
        <h1>Components of the page</h1>
        <section className="card" aria-label="Buttons">
          <h2>Buttons</h2>
          <div className="toolbar">
            <Button>Quiet</Button>
            <Button look="primary" icon={Play}>
              Primary
            </Button>
            <Button look="danger" icon={X}>
              Danger
            </Button>
            <Button look="plain">Plain</Button>
            <Button disabled>Disabled</Button>
            <Button aria-pressed={pressed} icon={Plus} onClick={() => press(!pressed)}>
              Pressed
            </Button>
            <IconButton icon={Pencil} label="Rename" keys="F2" />
            <IconButton icon={Undo2} label="Undo" disabled />
            <span className="group" role="group" aria-label="Group">
              <Button icon={Play}>All</Button>
              <IconButton icon={Square} label="Deactivate" />
              <IconButton icon={RotateCcw} label="Reset" />
            </span>
          </div>
        </section>
        <section className="card" aria-label="Fields">
          <h2>Fields</h2>
          <div className="toolbar">
            <label>
              Text <input defaultValue="0.0995" />
            </label>
            <label>
              Number <input type="number" defaultValue={3} />
            </label>
            <label>
              Refused <Refusable reason="its constraint is 1<=x<=9">{(said) => <input {...said} defaultValue="40" />}</Refusable>
            </label>
            <label>
              Off <input disabled defaultValue="read only" />
            </label>
            <label>
              Select{" "}
              <select defaultValue="b">
                <option value="a">first</option>
                <option value="b">second</option>
              </select>
            </label>
            <label>
              Slider <input type="range" defaultValue={40} />
            </label>
            <label>
              <input type="checkbox" defaultChecked /> on
            </label>
            <label>
              <input type="checkbox" /> off
            </label>
            <label>
              <input type="radio" name="choice" defaultChecked /> near
            </label>
            <label>
              <input type="radio" name="choice" /> far
            </label>
            <label>
              Search <input type="search" placeholder="Name, type" />
            </label>
            <label>
              Lines <textarea rows={2} defaultValue="several lines" />
            </label>
          </div>
        </section>
        <section className="card" aria-label="States and notices">
          <h2>States and notices</h2>
          <div className="toolbar">
            {STATES.map(([name, of]) => (
              <span key={name} className={`state ${of}`}>
                {name}
              </span>
            ))}
            <kbd>Ctrl K</kbd>
          </div>
          <p className="notice">{"Oven0.power and Thermostat0.temperature have different types\nW is not degC"}</p>
          <p className="notice ended">The run has ended at 46.500 s: the plant is not connected</p>
          <p className="reason">on_execute (src/oven.py:12): ValueError: too hot</p>
        </section>
        <section className="card" aria-label="Tabs and table">
          <h2>Tabs and table</h2>
          <Tabs label="Views of the gallery" names={VIEWS} shown={view} show={show}>
            <table>
              <thead>
                <tr>
                  <th scope="col">value</th>
                  <th scope="col">this run</th>
                  <th scope="col">unit</th>
                </tr>
              </thead>
              <tbody>
                <tr>
                  <th scope="row">{view}</th>
                  <td>1.053</td>
                  <td>rad</td>
                </tr>
              </tbody>
            </table>
          </Tabs>
          <ul className="tree">
            <li>
              <details open>
                <summary>rh3.host_cxt</summary>
                <ul>
                  <li>Arm0</li>
                  <li>Base0</li>
                </ul>
              </details>
            </li>
          </ul>
        </section>
        <section className="card" aria-label="Windows">
          <h2>Windows</h2>
          <div className="toolbar">
            <Button onClick={() => ask("window")}>Open the window</Button>
            <Button onClick={() => ask("question")}>Ask the question</Button>
            <Button onClick={() => ask("menu")}>Open the menu</Button>
          </div>
          <div className="frame">
            <Group orientation="horizontal">
              <Pane minSize="20%">
                <p className="empty">left pane</p>
              </Pane>
              <Separator className="grip horizontal" aria-label="Width of the panes" />
              <Pane minSize="20%">
                <p className="empty">right pane</p>
              </Pane>
            </Group>
          </div>
        </section>
      </main>
      {asked === "window" && (
        <Dialog title="A window" close={() => ask(undefined)}>
          <p>Text of a window.</p>
        </Dialog>
      )}
      {asked === "question" && <Question text="The edits are not saved. Discard them?" name="Discard" yes={() => undefined} close={() => ask(undefined)} />}
      {asked === "menu" && (
        <Menu
          place={{ label: "Menu", x: 80, y: 80 }}
          items={[
            { name: "Activate", act: () => undefined },
            { name: "Rename", act: () => undefined },
          ]}
          close={() => ask(undefined)}
        />
      )}
    </Tooltip.Provider>
  );
}
