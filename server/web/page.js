// What the daemon offers, asked of the daemon itself.

async function ask(path) {
    const answer = await fetch(path, { headers: { Accept: "application/json" } });
    if (!answer.ok) throw new Error(`${path}: ${answer.status}`);
    return answer.json();
}

async function showProcesses() {
    const list = document.getElementById("processes");
    for (const process of (await ask("v1/processes")).processes) {
        const item = document.createElement("li");
        item.textContent = `${process.title}: ${process.description}`;
        list.append(item);
    }
}

document.getElementById("version").value = (await ask("version")).version;
await showProcesses();
