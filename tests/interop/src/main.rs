//! Reads topics with hiroz, an implementation of ROS 2 on Zenoh that nobody here wrote.
//!
//!     hiroz_reader ENDPOINT DOMAIN list TOPIC...     all topics with their types, once these are there
//!     hiroz_reader ENDPOINT DOMAIN read TYPE TOPIC   the first message, as JSON

use std::{env, thread, time::Duration};

use hiroz::{Builder, Result, context::ZContextBuilder, node::ZNode};
use hiroz_msgs::{sensor_msgs::Image, sensor_msgs::Imu, std_msgs};
use serde_json::{Value, json};

const POLL: Duration = Duration::from_millis(50);

fn main() -> Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let [endpoint, domain, command @ ..] = words.as_slice() else {
        return Err("expected ENDPOINT DOMAIN and a command".into());
    };
    let context = ZContextBuilder::default()
        .with_mode("client")
        .with_connect_endpoints([*endpoint])
        .disable_multicast_scouting()
        .with_domain_id(domain.parse()?)
        .build()?;
    let node = context.create_node("hiroz_reader").build()?;
    match command {
        ["list", awaited @ ..] => list(&node, awaited),
        ["read", kind, topic] => println!("{}", read(&node, kind, topic)?),
        _ => return Err("expected list TOPIC..., or read TYPE TOPIC".into()),
    }
    Ok(())
}

fn list(node: &ZNode, awaited: &[&str]) {
    loop {
        let topics = node.graph().get_topic_names_and_types();
        if awaited
            .iter()
            .all(|it| topics.iter().any(|(name, _)| name == it))
        {
            for (name, kind) in topics {
                println!("{name} {kind}");
            }
            return;
        }
        thread::sleep(POLL);
    }
}

fn read(node: &ZNode, kind: &str, topic: &str) -> Result<Value> {
    Ok(match kind {
        "std_msgs/msg/String" => json!(node.create_sub::<std_msgs::String>(topic).build()?.recv()?),
        "sensor_msgs/msg/Imu" => json!(node.create_sub::<Imu>(topic).build()?.recv()?),
        "sensor_msgs/msg/Image" => json!(node.create_sub::<Image>(topic).build()?.recv()?),
        _ => return Err(format!("no reader for {kind}").into()),
    })
}
