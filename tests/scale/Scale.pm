# Servers for tests of stores that several daemons share, each started here on loopback, in a folder of its own, and ended with the
# program: a PostgreSQL with a pgbouncer before it, and a Swift with its S3 interface, which checks signatures.
package Scale;
use strict;
use warnings;
use Exporter 'import';
use File::Temp qw(tempdir);
use HTTP::Tiny;
use IO::Select;
use IO::Socket::INET;
use POSIX ();
use Vt;

our @EXPORT = qw(free_port child end_child ask start_postgres stop_postgres signal_postgres start_swift start_cutter objects follow);

our $dir = tempdir(CLEANUP => 1);
our %pid;
my $me = getpwuid $>;
my $http = HTTP::Tiny->new(timeout => $Vt::PATIENCE);
END { my $status = $?; end_child($_) for keys %pid; stop_postgres('immediate') if -e "$dir/data/postmaster.pid"; $? = $status }

# A port below those that connections get, and of this process alone, so that tests beside each other do not meet.
my $next_port = $$ * 16;
sub free_port {
    1 until IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => 10000 + ++$next_port % 22000, Listen => 1);
    return 10000 + $next_port % 22000;
}

sub write_file {
    my ($path, $text) = @_;
    open my $file, '>', $path or die "$path: $!";
    print $file $text;
    close $file;
}

# A child, with a process group of its own, that runs a program or a sub.
sub child {
    my ($name, @run) = @_;
    $pid{$name} = fork // die "fork: $!";
    return if $pid{$name};
    %pid = ();
    setpgrp;
    open STDOUT, '>>', "$dir/$name.out";
    open STDERR, '>&', \*STDOUT;
    $run[0]->() if ref $run[0];
    exec @run or POSIX::_exit(127);
}

sub end_child { kill '-KILL', delete $pid{ $_[0] } if $pid{ $_[0] } }

# --- PostgreSQL -------------------------------------------------------------------------------------------------------------------

my @as = $> == 0 ? qw(setpriv --reuid=postgres --regid=postgres --clear-groups) : (); # its programs do not run as root
our ($postgres, $pooler);

# A program as the user that may run it; what it says goes to a file.
sub as_user {
    my $pid = fork // die "fork: $!";
    if (!$pid) {
        %pid = ();
        open STDOUT, '>>', "$dir/postgres.out";
        open STDERR, '>&', \*STDOUT;
        exec @as, @_ or POSIX::_exit(127);
    }
    waitpid $pid, 0;
    return $?;
}

sub pg_ctl {
    my ($programs) = sort { $b cmp $a } glob '/usr/lib/postgresql/*/bin' or die 'PostgreSQL is not installed';
    return as_user("$programs/" . shift, '-D', "$dir/data", @_);
}
sub stop_postgres { return pg_ctl('pg_ctl', '-w', '-m', $_[0], 'stop') }
# To the server and all that it has started.
sub signal_postgres {
    my ($pid) = Vt::slurp("$dir/data/postmaster.pid") =~ /^(\d+)/;
    return kill $_[0], $pid, split ' ', Vt::slurp("/proc/$pid/task/$pid/children");
}

# Starts the server, again where it was stopped; true when it serves. Its pooler, in transaction mode, has two connections to it.
sub start_postgres {
    if (!$postgres) {
        ($postgres, $pooler) = (free_port(), free_port());
        chown +(getpwnam 'postgres')[2, 3], $dir if @as;
        chmod 0755, $dir;
        pg_ctl('initdb', '-A', 'trust', '-U', 'voronoid', '-E', 'UTF8', '--no-sync') == 0 or die Vt::slurp("$dir/postgres.out");
        write_file("$dir/pool.ini", "[databases]\n* = host=127.0.0.1 port=$postgres user=voronoid\n[pgbouncer]\nlisten_addr=127.0.0.1\n"
            . "listen_port=$pooler\nauth_type=any\npool_mode=transaction\ndefault_pool_size=2\nunix_socket_dir=\nserver_idle_timeout=1\n");
        child('pgbouncer', @as, '/usr/sbin/pgbouncer', "$dir/pool.ini");
    }
    return pg_ctl('pg_ctl', '-w', '-l', "$dir/postgres.log", '-o', "-p $postgres -c listen_addresses=127.0.0.1 -c fsync=off -k $dir", 'start') == 0;
}

# Of an SQL statement, what it returns.
sub ask {
    my ($database, $sql) = @_;
    open my $answer, '-|', 'psql', '-XqAt', "host=127.0.0.1 port=$postgres user=voronoid dbname=$database", '-c', $sql or die "psql: $!";
    local $/;
    return <$answer> =~ s/\s+\z//r;
}

# --- Swift ------------------------------------------------------------------------------------------------------------------------

our (%swift, $storage, %token);

# Starts it, with a bucket; true when it serves. The key is test:tester, its secret secret-word.
sub start_swift {
    %swift = map { $_ => free_port() } qw(memcached account container object proxy);
    mkdir "$dir/$_" or die "$dir/$_: $!" for qw(etc disks disks/one);
    write_file("$dir/etc/swift.conf", "[swift-hash]\nswift_hash_path_suffix = s\n[storage-policy:0]\nname = one\ndefault = yes\n");
    for my $kind (qw(account container object)) {
        my $ring = "swift-ring-builder $dir/etc/$kind.builder";
        system("$ring create 4 1 1 >/dev/null && $ring add r1z1-127.0.0.1:$swift{$kind}/one 1 >/dev/null && $ring rebalance >/dev/null") == 0
            or die 'no ring of Swift can be made';
        config($kind, "$kind-server", "[app:$kind-server]\nuse = egg:swift#$kind\n");
    }
    child('memcached', 'memcached', '-u', $me, '-l', '127.0.0.1', '-p', $swift{memcached});
    child($_, "swift-$_-server", "$dir/etc/$_.conf") for qw(account container object);
    start_proxy();
    @ENV{qw(AWS_ACCESS_KEY_ID AWS_SECRET_ACCESS_KEY)} = ('test:tester', 'secret-word');
    return wait_until(sub {
        my $answer = $http->get("http://127.0.0.1:$swift{proxy}/auth/v1.0", { headers => { 'X-Storage-User' => 'test:tester', 'X-Storage-Pass' => 'secret-word' } });
        $storage = $answer->{headers}{'x-storage-url'};
        %token = ('X-Auth-Token' => $answer->{headers}{'x-auth-token'});
        return $answer->{status} == 200 && $http->put("$storage/bucket", { headers => \%token })->{status} =~ /^20[12]$/;
    });
}

# What answers requests, anew where it runs; with another secret where one is given.
sub start_proxy {
    my ($secret) = @_;
    $secret //= 'secret-word';
    end_child('proxy');
    config('proxy', 'catch_errors cache s3api tempauth slo proxy-server', "[app:proxy-server]\nuse = egg:swift#proxy\naccount_autocreate = true\n"
        . "[filter:catch_errors]\nuse = egg:swift#catch_errors\n"
        . "[filter:cache]\nuse = egg:swift#memcache\nmemcache_servers = 127.0.0.1:$swift{memcached}\n"
        . "[filter:s3api]\nuse = egg:swift#s3api\nlocation = us-east-1\nstorage_domain = localhost\ns3_acl = false\n[filter:slo]\nuse = egg:swift#slo\n"
        . "[filter:tempauth]\nuse = egg:swift#tempauth\nuser_test_tester = $secret .admin\n");
    child('proxy', 'swift-proxy-server', "$dir/etc/proxy.conf");
}

sub config {
    my ($kind, $pipeline, $more) = @_;
    write_file("$dir/etc/$kind.conf", "[DEFAULT]\nbind_ip = 127.0.0.1\nbind_port = $swift{$kind}\nworkers = 0\nuser = $me\nswift_dir = $dir/etc\n"
        . "devices = $dir/disks\nmount_check = false\nlog_address = /nonexistent\n[pipeline:main]\npipeline = $pipeline\n$more");
}

# Of the proxy that stands before Swift, or before the first of these ports that answers, and cuts each connection after as many bytes as
# the sub says, now in a request, now in an answer.
sub start_cutter {
    my ($bytes, $port, @to) = @_;
    $port //= free_port();
    @to = $swift{proxy} if !@to;
    child('cutter', sub {
        my $listen = IO::Socket::INET->new(LocalAddr => '127.0.0.1', LocalPort => $port, Listen => 64, ReuseAddr => 1) or die "cutter: $!";
        local $SIG{CHLD} = 'IGNORE';
        srand 7;
        while (1) {
            my $client = $listen->accept or next;
            my $left = $bytes->();
            next if fork;
            relay($client, $left, @to);
            POSIX::_exit(0);
        }
    });
    return $port;
}

sub relay {
    my ($client, $left, @to) = @_;
    my $server;
    $server ||= IO::Socket::INET->new(PeerAddr => '127.0.0.1', PeerPort => $_) for @to;
    return unless $server;
    my $both = IO::Select->new($client, $server);
    while ($left > 0) {
        for my $from ($both->can_read) {
            my $size = sysread $from, my $bytes, $left < 4096 ? $left : 4096 or return;
            my $put = syswrite $from == $client ? $server : $client, $bytes or return;
            $left -= $put;
        }
    }
}

sub objects { return grep { length } split /\n/, $http->get("$storage/bucket", { headers => \%token })->{content} }
sub put_object { return $http->put("$storage/bucket/$_[0]", { headers => \%token, content => $_[1] }) }

# --- streams ----------------------------------------------------------------------------------------------------------------------

# Polls the events of a job up to the end, at any of the daemons, each time up to `most` and on from the last one. The number of the last
# one, how often an answer was cut, and how many events were missed or came twice. (A stream leaves out progress that its reader is late for.)
sub follow {
    my ($id, $most, @daemons) = @_;
    my ($last, $cuts, $bad, $at) = (0, 0, 0);
    while (1) {
        my $answer = $daemons[rand @daemons]->events("/v1/jobs/$id/events",
            headers => { Prefer => 'wait=5', Connection => 'close', $at ? ('Last-Event-ID' => $at) : () });
        my $left = 1 + int rand $most;
        while ($left-- > 0 && (my $event = $answer->next_event)) {
            my ($number) = ($at = $event->{id} // next) =~ /\.(\d+)$/;
            $bad++ if $number != $last + 1;
            $last = $number;
            return ($last, $cuts, $bad) if $event->{event} eq 'end';
        }
        $cuts += $left < 0;
    }
}

1;
