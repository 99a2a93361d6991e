# Varnish as a CDN before an HTTP store of .mvw files (mvw serve or nginx): whole files are kept, ranges are cut from
# them, and many who ask for one file at once cost the store one request.
#   varnishd -a :80 -f /etc/mvw/varnish.vcl -s malloc,1g
vcl 4.1;

backend store {
    .host = "10.0.0.11";
    .port = "8080";
}

sub vcl_recv {
    if (req.http.Upgrade ~ "(?i)websocket") {
        return (pipe);
    }
    if (req.url == "/healthz" || req.url == "/metrics" || req.http.Authorization || req.url ~ "[?&]token=") {
        return (pass);
    }
    if (req.url ~ "^/models/") {
        unset req.http.Cookie;
    }
}

sub vcl_pipe {
    set bereq.http.Upgrade = req.http.Upgrade;
    set bereq.http.Connection = req.http.Connection;
}

sub vcl_backend_response {
    # Names without a version are asked for again by their tag, which costs a 304.
    if (bereq.url ~ "^/models/" && beresp.http.Cache-Control !~ "immutable" && beresp.status == 200) {
        set beresp.ttl = 0s;
        set beresp.grace = 0s;
        set beresp.keep = 1h;
    }
}
