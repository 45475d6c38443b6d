#!/usr/bin/perl
# The snippets of `voronoid help proxies` for nginx, haproxy and caddy, word for word but for addresses, each before a real daemon that is
# started as it says: 100 MB pass, progress comes while the job runs, links lead back through the proxy.
# `make proxy` unpacks the three in build/proxy first.
use strict;
use warnings;
use Cwd qw(getcwd);
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../support";
use IO::Socket::INET;
use POSIX ();
use Test::More;
use Time::HiRes qw(time);
use Vt;

my $root = getcwd() . '/build/proxy/root';
my @libraries = glob "$root/usr/lib/*-linux-gnu";
my $host = 'cloud.example';
my $client = '127.0.0.2';
my $megabytes = 100;
my %running;
END { my $status = $?; kill 'KILL', $_ for keys %running; $? = $status }

my ($trusted) = Vt::slurp('server/cli/help/proxies.txt') =~ /^ +voronoid serve --trusted-proxy (\S+) --api-keys keys$/m
    or die 'the help does not start a daemon behind a proxy';

sub free_port {
    my $socket = IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => 0, Listen => 1) or die "no port: $!";
    return $socket->sockport;
}

sub listens {
    my ($port) = @_;
    return defined IO::Socket::INET->new(PeerAddr => '127.0.0.1', PeerPort => $port, Timeout => 5);
}

# A snippet with other addresses; every one must be there.
sub adapt {
    my ($text, %changes) = @_;
    for my $from (sort keys %changes) {
        $text =~ s/\Q$from\E/$changes{$from}/g or die "no $from in the snippet";
    }
    return $text;
}

# 2,000 points and as many bytes of another element as make it 100 MB: what is tried is the way, not the engine.
sub write_large {
    my ($path) = @_;
    my $cloud = sphere_ply(2000);
    my $padding = $megabytes * 1000 * 1000;
    my $piece = pack('C', 0) x 1_000_000;
    $cloud =~ s/(?=end_header\n)/element padding $padding\nproperty uchar x\n/;
    open my $out, '>:raw', $path or die "$path: $!";
    print $out $cloud;
    print $out $piece for 1 .. $megabytes;
    close $out or die "$path: $!";
}

# How each is started: its configuration, and the command.
sub nginx {
    my ($dir, $port, $text, %changes) = @_;
    my $site = adapt($text, 'listen 80;' => "listen 127.0.0.1:$port;", %changes);
    my $temp = join '', map { "${_}_temp_path $dir/$_;\n" } qw(client_body proxy fastcgi uwsgi scgi);
    my $user = $> == 0 ? "user root;\n" : '';
    spew("$dir/nginx.conf", "${user}daemon off;\npid $dir/pid;\nerror_log stderr;\nevents {}\n",
        "http {\naccess_log off;\n$temp$site}\n");
    return ("$root/usr/sbin/nginx", '-e', 'stderr', '-p', $dir, '-c', "$dir/nginx.conf");
}

my %proxies = (
    nginx => {
        scheme => 'http',
        start => sub { nginx(@_[0, 1], Vt::documented_in('nginx'), '127.0.0.1:8080' => $_[2]{address}) },
    },
    'nginx of docker/compose.scale.yaml' => {
        scheme => 'http',
        start => sub { nginx(@_[0, 1], Vt::slurp('docker/nginx.conf'), map { $_ => $_[2]{address} } 'api-1:8080', 'api-2:8080') },
    },
    haproxy => {
        scheme => 'http',
        start => sub {
            my ($dir, $port, $daemon) = @_;
            spew("$dir/haproxy.cfg", adapt(Vt::documented_in('haproxy'), 'bind :80' => "bind 127.0.0.1:$port",
                    '127.0.0.1:8080' => $daemon->{address}));
            return ("$root/usr/sbin/haproxy", '-db', '-f', "$dir/haproxy.cfg");
        },
    },
    caddy => {
        scheme => 'https',
        start => sub {
            my ($dir, $port, $daemon) = @_;
            # A certificate of its own, which no other program is told of, in the place of one from a public authority.
            my $site = adapt(Vt::documented_in('caddyfile'), '127.0.0.1:8080' => $daemon->{address},
                "$host {" => "$host:$port {\n    bind 127.0.0.1\n    tls internal");
            spew("$dir/Caddyfile", "{\n    admin off\n    skip_install_trust\n    auto_https disable_redirects\n",
                "    storage file_system $dir/storage\n}\n$site");
            $ENV{HOME} = $ENV{XDG_DATA_HOME} = $ENV{XDG_CONFIG_HOME} = $dir;
            return ("$root/usr/bin/caddy", 'run', '--adapter', 'caddyfile', '--config', "$dir/Caddyfile");
        },
    },
);

sub launch {
    my ($dir, @command) = @_;
    my $pid = fork // die "fork: $!";
    if ($pid) {
        $running{$pid} = 1;
        return $pid;
    }
    $ENV{LD_LIBRARY_PATH} = join ':', @libraries;
    open STDIN, '<', '/dev/null';
    open STDOUT, '>', "$dir/log";
    open STDERR, '>&', \*STDOUT;
    exec { $command[0] } @command or POSIX::_exit(127);
}

sub end {
    my ($pid) = @_;
    kill 'TERM', $pid;
    wait_until(sub { waitpid($pid, POSIX::WNOHANG()) != 0 }) or kill 'KILL', $pid;
    delete $running{$pid};
}

# From an address that is no proxy's, as any client's.
sub command {
    my ($via, @arguments) = @_;
    return ('curl', '-sSk', '--http1.1', '--interface', $client, '--resolve', "$host:$via->{port}:127.0.0.1", @arguments);
}

# curl by way of the proxy: status, head, body. What is behind @arguments goes to it as it is.
sub curl {
    my ($via, $path, @arguments) = @_;
    my $dir = tempdir(CLEANUP => 1);
    open my $out, '-|', command($via, '--max-time', 120, '-D', "$dir/head", '-o', "$dir/body", '-w', '%{http_code}',
        @arguments, "$via->{base}$path") or die "curl: $!";
    my $status = <$out> // '';
    close $out;
    return ($status, Vt::slurp("$dir/head"), Vt::slurp("$dir/body"));
}

# Every link of a document that does not begin with the proxy's address.
sub astray {
    my ($via, $text) = @_;
    my @hrefs = $text =~ /"href":"([^"]*)"/g;
    return @hrefs ? grep { index($_, "$via->{base}/") != 0 } @hrefs : ('no links');
}

# What a job does at the moments when its first event, and then its first of progress, have come by way of the proxy. It
# waits behind another one first: what little has been sent by then stays in a proxy that fills a buffer before it hands on.
sub statuses_at_events {
    my ($via, $daemon) = @_;
    my ($before, $id) = map { $daemon->submit('points=20000&iterations=10000', sphere_ply(20000)) } 1 .. 2;
    my $pid = open my $out, '-|', command($via, '-N', '--max-time', 20, "$via->{base}/v1/jobs/$id/events")
        or die "curl: $!";
    my @statuses;

    while (my $line = <$out>) {
        if (!@statuses && $line =~ /^event: status/) {
            push @statuses, $daemon->status($id);
            $daemon->request('DELETE', "/v1/jobs/$before");
        } elsif ($line =~ /^event: progress/) {
            push @statuses, $daemon->status($id);
            last;
        }
    }
    kill 'TERM', $pid;
    close $out;
    $daemon->request('DELETE', "/v1/jobs/$_") for $before, $id;
    return @statuses;
}

my $large = tempdir(CLEANUP => 1) . '/large.ply';
write_large($large);
for my $name (sort keys %proxies) {
    my $dir = tempdir(CLEANUP => 1);
    my $daemon = Vt->start(jobs => 1, 'trusted-proxy' => $trusted, 'no-auth' => 1);
    my $port = free_port();
    my $via = { port => $port, base => "$proxies{$name}{scheme}://$host:$port" };
    my $pid = launch($dir, $proxies{$name}{start}->($dir, $port, $daemon));
    my $up = wait_until(sub { listens($port) && (curl($via, '/readyz'))[0] eq '200' });

    ok $up, "$name answers for the daemon" or diag Vt::slurp("$dir/log"), $daemon->log_text;
    next unless $up;

    my $began = time;
    my ($status, $head, $body) = curl($via, '/v1/resample?points=200&iterations=2', '-T', $large, '-X', 'POST',
        '-H', 'Prefer: respond-async', '-H', 'X-Forwarded-For: 192.0.2.66', '-H', 'X-Forwarded-Host: evil.example',
        '-H', 'Forwarded: for=192.0.2.66;host=evil.example');
    is $status, 201, sprintf '%s lets %d MB through (%.1f s)', $name, $megabytes, time - $began;
    like $head, qr{^Location: \Q$via->{base}\E/v1/jobs/[0-9a-f-]+\r$}mi, "$name: Location leads back";
    is_deeply [astray($via, $body)], [], "$name: so do the links of the job";
    my ($id) = $body =~ /"jobID":"([^"]+)"/ or diag($body), next;
    is $daemon->finish($id)->{status}, 'successful', "$name: the job ends well";
    ($status, $head, $body) = curl($via, "/v1/jobs/$id/results/cloud");
    like $body, qr/^element vertex 200\n/m, "$name: its result comes back";
    is_deeply [map { astray($via, (curl($via, $_))[2]) } '/', '/v1/jobs', "/v1/jobs/$id", '/v1/processes'], [],
        "$name: all documents have the right links";
    is +(curl($via, '/v1/resample?points=5', '-X', 'POST', '-H', "Origin: $via->{base}", '-d', ''))[0], 422,
        "$name: a page of that origin may submit";

    is_deeply [statuses_at_events($via, $daemon)], ['accepted', 'running'],
        "$name: events come as they happen, while the job waits and while it runs";

    end($pid);
    is $daemon->stop, 0, "$name: the daemon ends with 0";
    my %clients = map { $_->{client} => 1 } grep { $_->{msg} eq 'request' } $daemon->log_lines;
    is_deeply [sort keys %clients], ['127.0.0.1', $client], "$name: the log has the client, whatever it says it is";
}
done_testing;
